"""The plain way: ``jupyter nbconvert --to slides`` makes what ``make slides`` makes.

``reveal/index.html.j2`` runs this file, because nbconvert reads no configuration from
the folder where it is called, but takes templates from there. It needs no installation,
and no other format of nbconvert comes past it.
"""

import sys
from pathlib import Path

from nbconvert.nbconvertapp import NbConvertApp

ROOT = Path(__file__).resolve().parents[1]


def page(metadata: dict[str, str]) -> str | None:
    """Return the lecturer's slides of a notebook of this project, as it is saved.

    Parameters
    ----------
    metadata : dict
        Where nbconvert has the notebook from: its folder, "path", and its "name".

    Returns
    -------
    str or None
        The page; none if the notebook does not stand in ``notebooks/``.

    Raises
    ------
    SystemExit
        With a sentence, if packages are missing or the notebook cannot be published.
    """
    folder = Path(metadata.get("path", "")).resolve()
    if folder != ROOT / "notebooks":
        return None
    try:
        return _slides(folder / f"{metadata['name']}.ipynb")
    except Exception as error:
        if NbConvertApp.initialized():  # a command; a server has to live on
            raise SystemExit(f"nbconvert: {error}") from error
        raise


def _slides(path: Path) -> str:
    sys.path.insert(0, str(ROOT))
    from publish.errors import PublishError

    try:
        from publish.page import slides_page
    except ModuleNotFoundError as error:
        raise PublishError(
            f"the Python package {error.name} is missing. "
            'Install what slides need with: pip install -e ".[publish]"'
        ) from error
    return slides_page(path)
