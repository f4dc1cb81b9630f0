"""What holds for every run of pytest, from every folder."""


def pytest_configure(config):
    """Read the path in pyproject.toml from the project's folder, for nbval."""
    path = config.getoption("nbval_sanitize_with", None)
    if path:
        config.option.nbval_sanitize_with = str(config.rootpath / path)


def pytest_collection_modifyitems(items):
    """Begin with the longest files: at the end no worker waits for one of them."""
    items.sort(key=lambda item: not is_long(item.path))


def is_long(path):
    """Whether the tests of a file need a kernel, or all handouts, for long."""
    return path.suffix == ".ipynb" or path.name in (
        "test_student.py",
        "test_chapter.py",
        "test_lab.py",
        "test_handouts.py",
    )
