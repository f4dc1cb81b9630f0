"""The plain way: ``jupyter nbconvert --to slides`` makes what ``make slides`` makes.

``reveal/index.html.j2`` runs this file, because nbconvert reads no configuration from
the folder where it is called, but takes templates from there. It needs no installation,
and no other format of nbconvert uses it.
"""

import sys
from pathlib import Path

from nbconvert.nbconvertapp import NbConvertApp

ROOT = Path(__file__).resolve().parents[2]


def page(metadata: dict[str, str]) -> str | None:
    """Return the lecturer's slides of a notebook, None of one outside ``notebooks/``.

    nbconvert says where it has the notebook from: its folder, "path", and its "name".
    """
    folder = Path(metadata.get("path", "")).resolve()
    if folder != ROOT / "notebooks":
        return None
    if str(ROOT) not in sys.path:
        sys.path.insert(0, str(ROOT))
    from pgm_book.make.errors import PublishError, missing

    try:
        from pgm_book.make.page import slides_page

        return slides_page(folder / f"{metadata['name']}.ipynb")
    except ModuleNotFoundError as error:
        problem: Exception = missing(error.name)
    except (PublishError, ValueError, OSError) as error:
        problem = error
    if NbConvertApp.initialized():  # the command; a server has to live on
        raise SystemExit(f"nbconvert: {problem}")
    raise problem
