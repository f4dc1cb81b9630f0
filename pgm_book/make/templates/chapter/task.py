"""The task of chapter NUMBER: the principal distance of a camera that saw a bus."""

from dataclasses import dataclass

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from pgm_book.common.checks import numbers
from pgm_book.task import Answer, Part, likeliest, table
from pgm_lab import plot

PIXEL, BUS, SIGMA = 0.004, 12.0, 0.5  # mm, m, and pixels: of one measured length


@dataclass(frozen=True)
class Truth:
    """The camera that photographed the bus, and what was measured."""

    answer: Answer  # c in mm
    H: np.ndarray  # m
    n: np.ndarray  # pixels

    @property
    def sd(self) -> float:
        """Standard deviation of c in mm: n = c L / (p H), each n as precise."""
        return SIGMA / np.sqrt(np.sum((BUS / (PIXEL * self.H)) ** 2))


def make(chance: np.random.RandomState) -> tuple[dict[str, str], Truth]:
    """Twelve photos of one bus, each from another height."""
    c = round(chance.uniform(7, 13), 2)
    H = np.round(np.sort(chance.uniform(40, 160, 12)), 1)
    n = np.round(c * BUS / (PIXEL * H) + SIGMA * chance.standard_normal(12), 1)
    bus = table("height_m,length_px", "{:.1f},{:.1f}", zip(H, n))
    return {"bus.csv": bus}, Truth({"c": c}, H, n)


def read(result: object) -> Answer:
    """Return the principal distance by its name, or say what is wanted."""
    return {"c": float(numbers("the result", result, wanted="one number: c in mm"))}


def judge(truth: Truth, found: Answer) -> list[Part]:
    """Return how far the principal distance is off, in standard deviations."""
    return [Part("c", abs(found["c"] - truth.answer["c"]) / truth.sd)]


def slips(truth: Truth) -> dict[str, Answer]:
    """Return what the likeliest wrong programs give."""
    c = truth.answer["c"]
    return {
        "The unit: c is wanted in millimetres.": {"c": c / 1000},
        "A bus of 12 m is n pixels long, not one pixel.": {"c": c / np.mean(truth.n)},
    }


def hint(truth: Truth, found: Answer, wrong: list[str]) -> str:
    """Return the hint to the slip that explains the result."""
    return (
        likeliest(judge, truth, found, wrong, slips(truth)) or "Draw the two triangles."
    )


def picture(truth: Truth, found: Answer) -> tuple[Figure, str]:
    """Draw the measured lengths, and what the result makes of them."""
    fig, ax = plt.subplots(figsize=(10, 4.5))
    H = np.linspace(40, 160, 121)
    ax.plot(H, found["c"] * BUS / (PIXEL * H), label="with your c")
    ax.plot(truth.H, truth.n, "o", color=plot.BLACK, label="measured")
    ax.set(xlabel="height in m", ylabel="length of the bus in pixels")
    ax.legend()
    return fig, (
        "The length of the bus in pixels over the height: twelve measured points, and"
        " the curve of your principal distance through them."
    )
