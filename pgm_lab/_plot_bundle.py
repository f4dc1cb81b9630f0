"""What the figures of bundles share: series, units, names, round numbers."""

import re

import numpy as np
from matplotlib.axis import Axis
from matplotlib.ticker import LogLocator, NullFormatter

from pgm_lab import plot

UM = 1e3  # micrometres in a millimetre
# Each series with a mark of its own, so that none is told by its colour alone
SERIES = (
    (plot.BLUE, "o"),
    (plot.RED, "s"),
    (plot.GREEN, "D"),
    (plot.ORANGE, "^"),
    (plot.PURPLE, "v"),
    (plot.SKY, "P"),
    (plot.BLACK, "X"),
)


def places(result, camera: int) -> dict[str, int]:
    """Row of each estimated interior parameter of a camera in the covariance."""
    end = f" of camera {camera + 1}" if len(result.cameras) > 1 else ""
    names = result.names[: len(result.sd_interior)]
    return {
        name.removesuffix(end): i for i, name in enumerate(names) if name.endswith(end)
    }


def camera_of_photos(result) -> np.ndarray:
    """Index of the camera of each photo."""
    given = result.network.camera
    return np.zeros(len(result.exteriors), int) if given is None else np.asarray(given)


def name_of(network, kind: str, index: int) -> str:
    names = getattr(network, f"{kind}_names")
    return str(index + 1 if names is None else names[index])


def round_number(value: float) -> float:
    """The largest of 1, 2 and 5 times a power of ten that is not above the value."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(max(digit * power for digit in (1, 2, 5) if digit * power <= value))


def symbol(name: str) -> str:
    """Parameters as formulas: "x0, P1" becomes "$x_0$, $P_1$"."""
    return re.sub(r"\b(omega|phi|kappa|(c|x|y|K|P|b|[XYZ])(\d?))\b", _formula, name)


def _formula(found: re.Match) -> str:
    word, letter, digit = found.groups()
    if letter:
        return f"${letter}_{digit}$" if digit else f"${letter}$"
    return r"$\varphi$" if word == "phi" else rf"$\{word}$"


def plain(axis: Axis, digits: tuple[int, ...] = (1, 2, 5)) -> None:
    """Number a logarithmic axis without powers of ten."""
    axis.set_major_locator(LogLocator(subs=digits, numticks=20))
    axis.set_major_formatter(lambda value, _: f"{value:g}")
    axis.set_minor_formatter(NullFormatter())
