"""The guides: what docs/ says on a reader's own network, photos and images."""

import shutil
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
PAGES = {
    "camera": "own_camera.md",
    "network": "own_network.md",
    "photos": "own_photos.md",
    "aerial": "own_aerial.md",
    "images": "own_images.md",
    "block": "block_of_photos.md",
}


def write(folder: Path) -> list[str]:
    """Write a page for each; return their names."""
    target = folder / "guides"
    target.mkdir()
    for name, file in PAGES.items():
        text = (ROOT / "docs" / file).read_text(encoding="utf-8")
        # The sample lies beside the pages, file by file.
        text = text.replace("[data/sample](../data/sample)", _sample(folder))
        for other, its_file in PAGES.items():
            text = text.replace(f"({its_file})", f"({other}.md)")
        (target / f"{name}.md").write_text(text, encoding="utf-8")
    return [f"guides/{name}" for name in PAGES]


def _sample(folder: Path) -> str:
    """Copy the sample network to the site; return links to its files."""
    target = folder / "files" / "guides"
    shutil.copytree(ROOT / "data" / "sample", target, dirs_exist_ok=True)
    names = sorted(path.name for path in target.iterdir())
    return "data/sample: " + ", ".join(
        f'<a href="{name}" download>{name}</a>' for name in names
    )
