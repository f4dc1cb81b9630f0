"""The table of the lessons in README, each with a picture, and README's large picture.

``python -m pgm_book.make.chapters`` renews them from data/chapters.csv, whose column
``figure`` says which stored figure of a notebook represents it, counted from 0.
"""

import base64
import io
import json
import re
import sys
from pathlib import Path

from PIL import Image

from pgm_book.common import chapters
from pgm_lab import datasets

ROOT = Path(__file__).resolve().parents[2]
README = ROOT / "README.md"
PICTURES = ROOT / "docs" / "pictures"
BEGIN, END = "<!-- chapters: from data/chapters.csv -->", "<!-- end of chapters -->"
SIZE = (300, 200)  # at most, in pixels: twice what README shows


def table() -> str:
    """Return a row for each lesson, with its picture and its case, in Markdown."""
    lines = ["| | lesson, an hour | its case, 45 minutes |", "|---|---|---|"]
    rows = {r["number"]: r for r in datasets.rows("chapters.csv") if r["notebook"]}
    for number, row in rows.items():
        if number.removesuffix("c") in rows and number.endswith("c"):
            continue
        picture = ""
        if row["figure"]:
            file = f"docs/pictures/{number}.png"
            picture = f'<img src="{file}" width="150" alt="{row["shows"]}">'
        case = _link(rows[f"{number}c"]) if f"{number}c" in rows else ""
        lines.append(f"| {picture} | **{number}** {_link(row)} | {case} |")
    return "\n".join([*lines, "", chapters.to_come()]).rstrip()


def _link(row: dict[str, str]) -> str:
    title = row["title"].removesuffix(": the case")
    more = f", {row['with']}" if row["with"] else ""
    return f"[{title}](notebooks/{row['notebook']}.ipynb){more}. {row['question']}"


def renewed(text: str) -> str:
    """Return the text of README with the table as data/chapters.csv has it now."""
    return replaced(text, BEGIN, END, table())


def replaced(text: str, begin: str, end: str, table: str) -> str:
    """Return the text with this table between two comments."""
    between = re.compile(f"{re.escape(begin)}.*{re.escape(end)}", re.DOTALL)
    new, number = between.subn(lambda _: f"{begin}\n\n{table}\n\n{end}", text)
    if number != 1:
        raise ValueError(f"the text must contain {begin} and {end} once")
    return new


def picture(row: dict[str, str]) -> Image.Image:
    """Return the stored figure that represents a notebook, reduced in size."""
    path = ROOT / "notebooks" / f"{row['notebook']}.ipynb"
    stored = [
        output["data"]["image/png"]
        for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]
        for output in cell.get("outputs", [])
        if "image/png" in output.get("data", {})
    ]
    png = base64.b64decode("".join(stored[int(row["figure"])]))
    image = Image.open(io.BytesIO(png)).convert("RGB")
    image.thumbnail(SIZE, Image.Resampling.LANCZOS)
    return image.quantize(64)


def main() -> int:
    """Renew README.md and its pictures."""
    import matplotlib

    matplotlib.use("agg")
    import matplotlib.pyplot as plt

    from pgm_lab import plot

    text = renewed(README.read_text(encoding="utf-8"))
    README.write_text(text, encoding="utf-8", newline="\n")
    PICTURES.mkdir(exist_ok=True)
    for row in datasets.rows("chapters.csv"):
        if row["figure"]:
            picture(row).save(PICTURES / f"{row['number']}.png", optimize=True)
    with plt.style.context(plot.STYLE):
        fig = plot.pixel_on_ground(datasets.yellowstone())
        fig.savefig(
            PICTURES / "pixel_on_ground.png", dpi=120, metadata={"Software": None}
        )
        plt.close(fig)
    return 0


if __name__ == "__main__":
    sys.exit(main())
