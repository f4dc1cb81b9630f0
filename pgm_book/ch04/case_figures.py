"""Printed rotation matrices on trial: which rows, columns and elements fail."""

from collections.abc import Mapping

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate, rotation
from pgm_lab.plot import basic


def matrices(omega: float, phi: float, kappa: float) -> dict[str, np.ndarray]:
    """Evaluate three printed rotation matrices, element by element as printed.

    Parameters
    ----------
    omega, phi, kappa : float
        Radians.

    Returns
    -------
    dict of str to ndarray (3, 3)
        (2.8) and (2.62) of Muliawan (2013), (3) of appendix B of Bani (2010). Of the
        last, the elements that are those of (2.8) are taken from there.

    Examples
    --------
    >>> list(matrices(0.3, 0.4, 0.5))
    ['(M 2.8)', '(B 3)', '(M 2.62)']
    """
    angles = [
        _validate.number(value, name)
        for value, name in ((omega, "omega"), (phi, "phi"), (kappa, "kappa"))
    ]
    (co, cp, ck), (so, sp, sk) = np.cos(angles), np.sin(angles)
    of_2013 = rotation.matrix(*angles)
    of_2010 = of_2013.copy()
    of_2010[0, 1] = so * ck + co * sk
    back = [
        [cp * ck, -cp * sk, co],
        [co * sk + so * sp * ck, co * sk - so * sp * sk, -so * cp],
        [so * sk - co * sp * ck, so * ck + co * sp * sk, co * cp],
    ]
    return {"(M 2.8)": of_2013, "(B 3)": of_2010, "(M 2.62)": np.array(back)}


def bench(matrices: Mapping[str, ArrayLike]) -> None:
    """Show a table of how far each matrix is from a rotation.

    Parameters
    ----------
    matrices : mapping of str to array_like (3, 3)
        The matrices by their names in print.
    """
    rows = [
        [name, f"{rotation.defect(m):.3f}", f"{np.linalg.det(m):.3f}"]
        for name, m in _all(matrices).items()
    ]
    head = ["printed matrix", "largest |MMᵀ − I|", "determinant"]
    basic.table(head, rows, "Three printed matrices at ω, φ, κ = 0.3, 0.4, 0.5 rad")


def rows_and_columns(matrices: Mapping[str, ArrayLike]) -> None:
    """Show which rows and which columns of each matrix fail.

    Parameters
    ----------
    matrices : mapping of str to array_like (3, 3)
        The matrices by their names in print.
    """
    several = _all(matrices)
    fig, axes = plt.subplots(2, len(several), figsize=(7, 5.0), squeeze=False)
    said = []
    for column, (name, m) in enumerate(several.items()):
        for ax, product in zip(axes[:, column], (m @ m.T, m.T @ m)):
            excess = product - np.eye(3)
            ax.imshow(excess, cmap="PuOr", vmin=-0.9, vmax=0.9)
            for (i, j), value in np.ndenumerate(excess):
                color = "white" if abs(value) > 0.6 else "black"
                number = f"{round(value, 2) + 0.0:.2f}".replace("-", "−")
                text = ax.text(j, i, number, color=color, fontsize=14)
                text.set(ha="center", va="center")
            ax.set(xticks=range(3), yticks=range(3))
            ax.set(xticklabels=range(1, 4), yticklabels=range(1, 4))
            ax.tick_params(length=0, labelsize=14)
            ax.grid(False)
        axes[0, column].set_title(name, loc="center")
        axes[0, column].set_xlabel("row")
        axes[1, column].set_xlabel("column")
        said.append(f"{name}: {_numbers(m @ m.T)} of M Mᵀ, {_numbers(m.T @ m)} of Mᵀ M")
    axes[0, 0].set_ylabel("MMᵀ − I\nrow")
    axes[1, 0].set_ylabel("MᵀM − I\ncolumn")
    basic.show(
        fig,
        "M Mᵀ − I, which compares rows, and Mᵀ M − I, which compares columns. Elements"
        " off by more than 0.005: " + "; ".join(said) + ".",
    )


def _all(matrices: Mapping[str, ArrayLike]) -> dict[str, np.ndarray]:
    several = {
        name: _validate.of_shape(m, (3, 3), f"matrices, {name}")
        for name, m in _validate.mapping(matrices, "matrices").items()
    }
    if not several:
        raise ValueError("matrices must hold one matrix or more")
    return several


def _numbers(product: ArrayLike) -> str:
    """The elements, counted from 1, in which a product is not the unit matrix."""
    wrong = np.argwhere(np.abs(np.asarray(product) - np.eye(3)) > 0.005) + 1
    return " ".join(f"({i}, {j})" for i, j in wrong) or "none"
