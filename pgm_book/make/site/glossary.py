"""The glossary as a page, each term in English and in Indonesian."""

import re
from pathlib import Path

from pgm_lab import datasets

HEAD = """\
# Glossary

```{glossary}
"""


def write(folder: Path) -> list[str]:
    """Write the page of the glossary; return its name."""
    chapters = {row["number"]: row["notebook"] for row in datasets.rows("chapters.csv")}
    entries = []
    for row in datasets.rows("glossary.csv"):
        terms = [row["english"], row["indonesian"]]
        # The search finds an entry by most of its letters: a short name by itself.
        terms += re.findall(r"\((.+?)\)", " ".join(terms))
        terms = list(dict.fromkeys(terms))
        chapter = row["chapter"]
        link = f"Chapter {chapter}"
        if chapters.get(chapter):
            link = f"[{link}](chapters/{chapters[chapter]})"
        entries.append("\n".join([*terms, f"  {row['meaning']}. {link}"]))
    page = HEAD + "\n\n".join(entries) + "\n```\n"
    (folder / "glossary.md").write_text(page, encoding="utf-8")
    return ["glossary"]
