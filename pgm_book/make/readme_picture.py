"""Draw the picture of the README: `python -m pgm_book.make.readme_picture`."""

from pathlib import Path

import matplotlib

matplotlib.use("agg")

import matplotlib.pyplot as plt  # noqa: E402  (the backend must be chosen first)

from pgm_lab import datasets, plot  # noqa: E402

PICTURE = Path(__file__).resolve().parents[2] / "docs" / "pixel_on_ground.png"


def main() -> None:
    """Write the picture into docs/."""
    PICTURE.parent.mkdir(exist_ok=True)
    with plt.style.context(plot.STYLE):
        fig = plot.pixel_on_ground(datasets.yellowstone())
        fig.savefig(PICTURE, dpi=120, metadata={"Software": None})
        plt.close(fig)


if __name__ == "__main__":
    main()
