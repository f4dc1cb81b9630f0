"""Let nbval find its settings from every folder, as in `cd notebooks; pytest`."""


def pytest_configure(config):
    """Read the path in pyproject.toml from the project's folder."""
    path = config.getoption("nbval_sanitize_with", None)
    if path:
        config.option.nbval_sanitize_with = str(config.rootpath / path)
