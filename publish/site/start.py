"""The first page, and the table of contents."""

from pathlib import Path

TOCTREE = """\
```{{toctree}}
:hidden:
:maxdepth: 2

{pages}
```
"""


def write(folder: Path, pages: dict[str, list[str]]) -> None:
    """Write the first page and a page for each part that has several."""
    top = []
    for part, names in pages.items():
        if names == [part]:
            top.append(part)
            continue
        if names:
            page = f"# {part.capitalize()}\n\n" + _toctree(names)
            (folder / part / "index.md").write_text(page, encoding="utf-8")
            top.append(f"{part}/index")
    page = "# pgm_lab\n\n" + _toctree(top)
    (folder / "index.md").write_text(page, encoding="utf-8")


def _toctree(names: list[str]) -> str:
    return TOCTREE.format(pages="\n".join(f"/{name}" for name in names))
