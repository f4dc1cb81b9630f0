"""The guides: what README says on a reader's own network, photos and images.

The note on a block of photos comes along, since README leads to it.
"""

import re
import shutil
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
SECTIONS = {
    "network": "Your own network",
    "photos": "Your own photos",
    "aerial": "Your own aerial photos",
    "images": "Your own images",
}
BLOCK = "docs/block_of_photos.md"


def write(folder: Path) -> list[str]:
    """Write a page for each section of README; return their names."""
    target = folder / "guides"
    target.mkdir()
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    for name, heading in SECTIONS.items():
        text = f"# {heading}\n{section(readme, heading)}"
        # The sample lies beside the pages, file by file.
        text = text.replace("[data/sample](data/sample)", _sample(folder))
        text = text.replace(f"({BLOCK})", "(block.md)")
        (target / f"{name}.md").write_text(text, encoding="utf-8")
    shutil.copy(ROOT / BLOCK, target / "block.md")
    return [f"guides/{name}" for name in (*SECTIONS, "block")]


def section(text: str, heading: str) -> str:
    """Return what stands below a heading of the second level, up to the next."""
    found = re.search(rf"^## {re.escape(heading)}\n(.*?)(?=^## |\Z)", text, re.M | re.S)
    if not found:
        raise ValueError(f"README.md has no section {heading!r}")
    return found[1]


def _sample(folder: Path) -> str:
    """Copy the sample network to the site; return links to its files."""
    target = folder / "files" / "guides"
    shutil.copytree(ROOT / "data" / "sample", target, dirs_exist_ok=True)
    names = sorted(path.name for path in target.iterdir())
    return "data/sample: " + ", ".join(
        f'<a href="{name}" download>{name}</a>' for name in names
    )
