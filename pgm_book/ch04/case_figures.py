"""Printed rotation matrices examined: which rows, columns and elements fail."""

from collections.abc import Mapping

import matplotlib.pyplot as plt
import numpy as np

from pgm_lab import plot, rotation


def bench(matrices: Mapping[str, np.ndarray]) -> None:
    """Show a table of how far each matrix is from a rotation."""
    rows = [
        [name, f"{rotation.defect(m):.3f}", f"{np.linalg.det(m):.3f}"]
        for name, m in matrices.items()
    ]
    head = ["printed matrix", "largest |MMᵀ − I|", "determinant"]
    plot.table(head, rows, "Three printed matrices at ω, φ, κ = 0.3, 0.4, 0.5 rad")


def rows_and_columns(matrices: Mapping[str, np.ndarray]) -> None:
    """Show which rows and which columns of each matrix fail."""
    fig, axes = plt.subplots(2, len(matrices), figsize=(7, 5.0), squeeze=False)
    said = []
    for column, (name, m) in enumerate(matrices.items()):
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
    plot.show(
        fig,
        "M Mᵀ − I, which compares rows, and Mᵀ M − I, which compares columns. Elements"
        " off by more than 0.005: " + "; ".join(said) + ".",
    )


def _numbers(product: np.ndarray) -> str:
    """The elements, counted from 1, in which a product is not the unit matrix."""
    wrong = np.argwhere(np.abs(np.asarray(product) - np.eye(3)) > 0.005) + 1
    return " ".join(f"({i}, {j})" for i, j in wrong) or "none"
