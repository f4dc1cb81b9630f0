"""The verdicts as a table to search."""

from pathlib import Path


def write(folder: Path) -> list[str]:
    """Write the page of the verdicts; return its name for the table of contents."""
    (folder / "verdicts.md").write_text("# Verdicts\n", encoding="utf-8")
    return ["verdicts"]
