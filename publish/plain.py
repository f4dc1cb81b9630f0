"""The plain way: ``jupyter nbconvert --to slides`` makes what ``make slides`` makes.

nbconvert looks for the template of slides, ``reveal``, in the folder where it is called
before it takes its own. In the clone it finds the folder of that name, which leads here.
"""

from pathlib import Path

from nbconvert.nbconvertapp import NbConvertApp
from nbconvert.preprocessors import Preprocessor
from nbformat import NotebookNode

from publish.errors import PublishError


class Lecture(Preprocessor):
    """Puts the lecturer's slides of a notebook, as it is saved, into the resources."""

    def preprocess(
        self, nb: NotebookNode, resources: dict
    ) -> tuple[NotebookNode, dict]:
        """Return the notebook unchanged, and the resources with the whole page.

        Raises
        ------
        SystemExit
            With a sentence, if packages are missing or the notebook cannot be shown.
        PublishError
            The same where a server, not the command, asked: that goes on.
        """
        metadata = resources["metadata"]
        path = Path(metadata.get("path", ""), f"{metadata['name']}.ipynb")
        try:
            resources["page"] = _page(path)
        except PublishError as error:
            if not NbConvertApp.initialized():
                raise
            raise SystemExit(f"nbconvert: {error}") from error
        return nb, resources


def _page(path: Path) -> str:
    """Return the page; whatever is wrong, what is raised says so in a sentence."""
    try:
        from publish.page import slides_page

        return slides_page(path)
    except ModuleNotFoundError as error:
        raise PublishError(
            f"the Python package {error.name} is missing. "
            'Install what slides need with: pip install -e ".[publish]"'
        ) from error
    except (OSError, ValueError) as error:
        raise PublishError(str(error)) from error
