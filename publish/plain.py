"""The plain way: ``jupyter nbconvert --to slides`` makes what ``make slides`` makes.

``pip install -e .`` puts ``jupyter_nbconvert_config.json`` where Jupyter finds it in this
environment, and that names `Lecture`. Jupyter reads no configuration from the folder
where it is called. Notebooks of other projects get the slides of nbconvert, as ever.
"""

from pathlib import Path

from nbconvert.preprocessors import Preprocessor
from nbformat import NotebookNode

from publish.errors import PublishError

TEMPLATES = Path(__file__).parent / "templates"


class Lecture(Preprocessor):
    """Lets the exporter write the lecturer's slides, from the notebook as it is saved."""

    def preprocess(
        self, nb: NotebookNode, resources: dict
    ) -> tuple[NotebookNode, dict]:
        """Return the notebook unchanged, and the resources with the whole page.

        Raises
        ------
        SystemExit
            With a sentence, if packages are missing or the notebook cannot be shown.
        """
        metadata = resources["metadata"]
        path = Path(metadata.get("path", ""), f"{metadata['name']}.ipynb").resolve()
        if not (path.parents[1] / "publish" / "plain.py").exists():
            return nb, resources
        self.parent.extra_template_basedirs = [str(TEMPLATES)]
        self.parent.template_name = "pgm_plain"
        try:
            return nb, resources | {"page": _page(path)}
        except (PublishError, ValueError, OSError) as error:
            raise SystemExit(f"nbconvert: {error}") from error


def _page(path: Path) -> str:
    try:
        from publish.page import slides_page
    except ModuleNotFoundError as error:
        raise PublishError(
            f"the Python package {error.name} is missing. "
            'Install what slides need with: pip install -e ".[publish]"'
        ) from error
    return slides_page(path)
