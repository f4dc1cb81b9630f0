"""The one error of publishing: something a person can put right."""


class PublishError(Exception):
    """Publishing stopped; the message says what was wrong and what to do."""


def missing(package: str | None, said: str = "") -> PublishError:
    """Return the error that a Python package is missing, and how to install it."""
    said = said and f"{said}the Python package {package}. "
    return PublishError(
        (said or f"the Python package {package} is missing. ")
        + 'Install what publishing needs with: pip install -e ".[publish]"'
    )
