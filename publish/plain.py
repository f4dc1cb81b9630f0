"""The plain way: `jupyter nbconvert --to slides` makes what `make slides` makes.

`jupyter_nbconvert_config.py` leads here, and the template `pgm_plain` writes the page.
"""

from pathlib import Path

from nbformat import NotebookNode

from publish.errors import PublishError


def lecture(notebook: NotebookNode, resources: dict) -> tuple[NotebookNode, dict]:
    """Put the lecturer's slides of a notebook into `resources`, as a whole page.

    A preprocessor of nbconvert. What is wrong ends the command with a sentence, which
    also names what to install where the packages for publishing are missing.
    """
    metadata = resources["metadata"]
    path = Path(metadata["path"], f"{metadata['name']}.ipynb")
    try:
        from publish.page import slides_page

        resources["page"] = slides_page(path)
    except ModuleNotFoundError as error:
        raise SystemExit(
            f"nbconvert: the Python package {error.name} is missing. "
            'Install what slides need with: pip install -e ".[publish]"'
        ) from error
    except (PublishError, ValueError, OSError) as error:
        raise SystemExit(f"nbconvert: {error}") from error
    return notebook, resources
