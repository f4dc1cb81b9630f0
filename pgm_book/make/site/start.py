"""The first page, with one prediction to click, and the table of contents."""

import shutil
from pathlib import Path

from pgm_book.common import chapters

ROOT = Path(__file__).resolve().parents[3]
PICTURE = "pixel_on_ground.png"
TITLES = {"chapters": "Chapters", "guides": "Guides", "reference": "Reference"}
INTRODUCTIONS = {
    "chapters": "Read in this order, A1 after chapter 1. Each page shows what the "
    "notebook shows when it has been run; predictions and solutions open with a click."
    "\n\n{table}",
    "guides": "Programs for measurements and images of your own.",
    "reference": "What the notebooks call, a page for each package. Equations are "
    "cited as (M 2.95) for Muliawan 2013, (B 2.10) for Bani 2010, (H 4) for Harintaka "
    "2020 and (Br 2) for Brahmantara 2015: search for one to find its functions.",
}
START = """\
---
html_theme.sidebar_secondary.remove: true
---

# Photogrammetry you can check to the last digit

From a pixel to a calibrated camera in notebooks and tested functions, with the \
published numbers of four studies checked.

<div class="pgm-start"><div>

```{{image}} {picture}
:alt: A camera above a real orthophoto; the rays of one pixel run from the \
perspective centre through the image to a square on the ground, its GSD.
:class: pgm-first
```

</div><div>

**How large is a pixel on the ground?** A camera flies H = 1000 m above a village. Its \
lens has c = 24 mm, a pixel on its sensor is 5.49 µm wide. In 2020 the pixel on the \
ground was printed as 20 cm. What do you expect?

{prediction}

<div class="pgm-waits">

A wrong pixel size does not look wrong in any picture. It shows in each length \
and area that is measured by counting pixels: from 1000 m a pixel covers 31 per cent \
more ground than printed. [Chapter 1](chapters/01_pixel_to_photo.ipynb) works it out.

</div></div></div>

::::{{grid}} 1 1 3 3
:gutter: 3

:::{{grid-item-card}} Students
Predict, look, and write your own program, step by \
step. [Start here](chapters/00_start_here.ipynb), or look up a word \
in the [glossary](glossary.md).
:::

:::{{grid-item-card}} Lecturers
See the [chapters](chapters/index.md) with their minutes, and the \
[verdicts](verdicts.md) on what was printed, each with its proof. In a clone \
`make slides` and `make handouts` write a deck and a PDF of each chapter.
:::

:::{{grid-item-card}} Engineers
Try [your own network](guides/network.md), [photos](guides/photos.md), \
[aerial photos](guides/aerial.md) or [images](guides/images.md), and find an \
equation in the [index](/equations) or a function in the \
[reference](reference/index.md).
:::
::::

{toctree}
"""
CHOICES = (
    (
        "15 cm",
        False,
        "H / c is about 42,000, and 42,000 × 5.49 µm is more than 20 cm.",
    ),
    (
        "20 cm, as printed",
        False,
        "Then the camera would have to fly at 874 m: 1000 m / 24 mm × 5.49 µm is more.",
    ),
    ("23 cm", True, "1000 m / 24 mm × 5.49 µm = 22.9 cm."),
)
TOCTREE = """\
```{{toctree}}
:hidden:
:maxdepth: 2

{pages}
```
"""


def write(folder: Path, pages: dict[str, list[str]]) -> None:
    """Write the first page, and a page for each part that has several."""
    top = []
    for part, names in pages.items():
        if part in TITLES:
            words = INTRODUCTIONS[part].format(table=chapters.markdown())
            links = "" if part == "chapters" else _list(names)
            page = f"# {TITLES[part]}\n\n{words}\n\n{links}\n\n{_toctree(names)}"
            (folder / part / "index.md").write_text(page, encoding="utf-8")
            top.append(f"{part}/index")
        else:
            top += names
    shutil.copy(ROOT / "docs" / "pictures" / PICTURE, folder)
    page = START.format(picture=PICTURE, prediction=prediction(), toctree=_toctree(top))
    (folder / "index.md").write_text(page, encoding="utf-8")


def prediction() -> str:
    """Write the choices as `pgm_book.common.checks.predict` does."""
    folded = [
        f'<details name="start"><summary>{choice}</summary>'
        f"<p>{'✓' if right else '✗'} {said}</p></details>"
        for choice, right, said in CHOICES
    ]
    return "\n".join(['<div class="pgm-predict">', *folded, "</div>"])


def _list(names: list[str]) -> str:
    return "\n".join(f"- [](/{name})" for name in names)


def _toctree(names: list[str]) -> str:
    return TOCTREE.format(pages="\n".join(f"/{name}" for name in names))
