"""Figures of the frames on a sensor, and of what a pixel is on the ground."""

import matplotlib.pyplot as plt
import numpy as np
import scipy
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from pgm_lab import image, plot, simulate
from pgm_lab.plot.basic import Look, interact

Place = tuple[float, float]

ARROW: Look = {"arrowstyle": "-|>", "mutation_scale": 24, "linewidth": 2.6}
LABEL: Look = {
    "fontsize": 15,
    "bbox": {"facecolor": "white", "edgecolor": "none", "alpha": 0.88, "pad": 2},
}
WAYS = (
    ("centres, from 0", "NumPy, OpenCV, here", 0.0, plot.BLUE),
    ("corners, from 0", "GIS, some viewers", 0.5, plot.RED),
    ("centres, from 1", "MATLAB", 1.0, plot.GREEN),
)


def sensor_frames() -> None:
    """Show the pixel frame and the photo frame on one sensor, with 8 x 6 pixels."""
    fig, ax = plt.subplots(figsize=(10, 5.6))
    for edge in np.arange(-0.5, 8):
        ax.plot([edge, edge], [-0.5, 5.5], color=plot.SKY, linewidth=0.8)
    for edge in np.arange(-0.5, 6):
        ax.plot([-0.5, 7.5], [edge, edge], color=plot.SKY, linewidth=0.8)
    outline = plt.Rectangle((-0.5, -0.5), 8, 6, fill=False, linewidth=2)
    ax.add_patch(outline)
    _axis(ax, (0, 0), (2.4, 0), "X (column)", plot.BLUE, (2.5, -0.02))
    _axis(ax, (0, 0), (0, 2.4), "Y (row)", plot.BLUE, (0.1, 2.25))
    _axis(ax, (3.5, 2.5), (6.3, 2.5), "x (mm)", plot.RED, (6.4, 2.5))
    _axis(ax, (3.5, 2.5), (3.5, 0.1), "y (mm)", plot.RED, (3.6, 0.35))
    ax.plot(0, 0, "o", color=plot.BLUE, markersize=11)
    ax.plot(3.5, 2.5, "s", color=plot.RED, markersize=11)
    said = {"arrowprops": {"arrowstyle": "-"}, "va": "center", **LABEL}
    ax.annotate("centre of the\nfirst pixel: (0, 0)", (0, 0), (-2.9, 1.1), **said)
    ax.annotate("image centre\n$(X_c, Y_c)$", (3.5, 2.5), (1.35, 3.7), **said)
    point = (5.6, 1.3)
    ax.plot(*point, "*", color=plot.BLACK, markersize=18)
    ax.annotate("a point", point, (6.0, 0.75), **LABEL)
    size = {"arrowstyle": "<->", "linewidth": 2, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", (6.5, 5.75), (7.5, 5.75), arrowprops=size)
    ax.text(7, 6.15, "$p_x$", ha="center", **LABEL)
    ax.annotate("", (7.75, 4.5), (7.75, 5.5), arrowprops=size)
    ax.text(7.9, 5, "$p_y$", va="center", **LABEL)
    ax.set(xlim=(-3.1, 8.6), ylim=(6.4, -0.8), aspect="equal")
    ax.axis("off")
    plot.show(
        fig,
        "A sensor of 8 by 6 pixels. The pixel frame begins at the centre of the first"
        " pixel at the upper left, its X axis points right and its Y axis down. The"
        " photo frame begins at the image centre, its x axis points right and its y"
        " axis up. A pixel is px wide and py high.",
    )


def interior_orientation() -> None:
    """Show the interior orientation, its parts named: a sketch, not to scale."""
    fig, ax = plt.subplots(figsize=(8.2, 5.1))
    centre = (0.0, 0.0, 13.0)
    principal = (2.4, -2.6, 0.0)
    point = (7.6, 3.6, 0.0)
    corners = 11.8 * np.array(
        [(-1, -0.67, 0), (1, -0.67, 0), (1, 0.67, 0), (-1, 0.67, 0)]
    )
    ax.fill(*_oblique(corners).T, color=plot.SKY, alpha=0.25)
    ax.plot(
        *_oblique(np.vstack([corners, corners[:1]])).T, color=plot.BLUE, linewidth=1.5
    )
    top = (principal[0], principal[1], centre[2])
    ax.plot(*_oblique([top, principal]).T, "--", color=plot.BLACK, linewidth=2.4)
    far = np.array(top) + 1.45 * (np.array(point) - top)
    ax.plot(*_oblique(np.array([top, far])).T, color=plot.GREEN, linewidth=2.6)
    origin = _oblique([(0, 0, 0)])[0]
    for end, name in (((8.0, 0.0, 0.0), "x"), ((0.0, 6.0, 0.0), "y")):
        _axis(ax, origin, _oblique([end])[0], name, plot.RED, _oblique([end])[0] + 0.2)
    first = _oblique([(-11.5, 7.6, 0)])[0]
    for end, name in (((-6.5, 7.6, 0.0), "X"), ((-11.5, 3.4, 0.0), "Y")):
        at = _oblique([end])[0]
        _axis(ax, first, at, name, plot.BLUE, at + (0.2, -0.9))
    marks = (
        (top, "o", plot.BLACK, "perspective centre", (0.8, 0.2)),
        (principal, "o", plot.BLACK, "principal point $(x_0, y_0)$", (-3.0, -4.8)),
        ((0, 0, 0), "s", plot.RED, "image centre", (-9.6, -1.7)),
        (point, "*", plot.GREEN, "photo point $(x, y)$", (0.9, 0.1)),
    )
    for at, marker, colour, name, (right, up) in marks:
        u, v = _oblique([at])[0]
        ax.plot(u, v, marker, color=colour, markersize=13)
        away = {"arrowprops": {"arrowstyle": "-"}} if right < 0 else {}
        ax.annotate(name, (u, v), (u + right, v + up), **(LABEL | away))
    u, v = _oblique([(principal[0], principal[1], 7.5)])[0]
    ax.text(u - 0.4, v, "c", ha="right", **(LABEL | {"fontsize": 21}))
    u, v = _oblique([far])[0]
    ax.text(u + 0.6, v, "ray, to the ground", color=plot.GREEN, va="center", **LABEL)
    u, v = _oblique([corners[0]])[0]
    ax.text(u + 0.5, v - 1.3, "image plane", color=plot.BLUE, **LABEL)
    ax.set(xlim=(-17, 22), ylim=(-7.5, 14), aspect="equal")
    ax.axis("off")
    plot.show(
        fig,
        "A camera from the side. A dashed line of length c leads from the perspective"
        " centre straight down to the principal point in the image plane. The image"
        " centre, where the axes x and y begin, lies a little beside it. A ray runs"
        " from the perspective centre through the photo point on to the ground.",
    )


def pixel_conventions() -> None:
    """Show one point of the first pixels under three ways to count."""
    fig, axes = plt.subplots(1, 3, figsize=(10, 4.7), sharey=True)
    told = []
    for ax, (title, who, shift, colour) in zip(axes, WAYS):
        for edge in np.arange(-0.5, 3.0):
            ax.plot([-0.5, 2.5], [edge, edge], color=plot.GREY, linewidth=1)
            ax.plot([edge, edge], [-0.5, 2.5], color=plot.GREY, linewidth=1)
        ax.plot(1.3, 0.8, "*", color=plot.BLACK, markersize=18)
        origin = np.array([-shift, -shift])
        ends = origin + (1, 0), origin + (0, 1)
        plot.frame(ax, origin, *ends, ("X", "Y"), color=colour)
        text = f"({1.3 + shift:.1f}, {0.8 + shift:.1f})"
        ax.text(1.0, 3.1, text, ha="center", fontsize=20, color=colour, weight="bold")
        ax.set_title(f"{title}\n{who}", loc="center", color=colour)
        ax.set(xlim=(-1.3, 2.7), ylim=(3.3, -1.3), aspect="equal")
        ax.axis("off")
        told.append(f"{text} with {title}")
    plot.show(
        fig,
        "The same star in the first 3 by 3 pixels under three conventions: "
        + ", ".join(told)
        + ". Arrows start at each origin.",
    )


def ground_frame(grey: np.ndarray, gsd: float, sizes: np.ndarray) -> None:
    """Show a part of an orthophoto with larger and larger pixels."""
    side = min(grey.shape)
    fig, axes = plt.subplots(1, len(sizes), figsize=(6.6, 2.75), squeeze=False)
    for ax, wanted in zip(axes[0], sizes):
        edges = np.linspace(0, side, max(2, round(side * gsd / wanted) + 1))
        summed = np.pad(grey[:side, :side], ((1, 0), (1, 0))).cumsum(0).cumsum(1)
        at = np.meshgrid(edges, edges, indexing="ij")
        corners = scipy.ndimage.map_coordinates(summed, at, order=1)
        area = np.outer(np.diff(edges), np.diff(edges))
        ax.imshow(np.diff(np.diff(corners, axis=0), axis=1) / area)
        ax.set_title(f"{100 * wanted:.0f} cm", loc="center")
        ax.axis("off")
    each = ", ".join(f"{100 * one:.0f}" for one in sizes)
    words = f"The same {side * gsd:.0f} metres of ground with pixels of {each} cm."
    plot.show(fig, words, colours=64)


def _axis(
    ax: Axes, start: Place, end: Place, name: str, colour: str, at: Place
) -> None:
    """Draw an axis as an arrow, and write its name at a place."""
    look = ARROW | {"color": colour, "shrinkA": 0}
    ax.annotate("", end, start, arrowprops=look)
    ax.text(*at, name, color=colour, weight="bold", va="center", **LABEL)


def _oblique(points: ArrayLike) -> np.ndarray:
    """Draw points in space on paper: x to the right, y to the back, z up."""
    x, y, z = np.asarray(points, dtype=float).T
    return np.column_stack([x + 0.5 * y, z + 0.4 * y])


def mirror(computed: np.ndarray, printed: np.ndarray) -> None:
    """Show computed and printed photo coordinates of one photo, joined by lines."""
    fig, ax = plt.subplots(figsize=(5.4, 4.5))
    for a, b in zip(computed, printed):
        ax.plot(*zip(a, b), color=plot.GREY, linewidth=1)
    ax.plot(*computed.T, "o", color=plot.BLUE, label="computed from Table 4.1")
    ax.plot(
        *printed.T, "D", color=plot.RED, mfc="none", mew=2, label="printed in Table 4.2"
    )
    ax.axhline(0, color=plot.BLACK, linewidth=1.5)
    ax.set(xlabel="x (mm)", ylabel="y (mm)", aspect="equal")
    fig.legend(loc="outside lower center", ncols=1)
    apart = np.abs(computed - printed).max(axis=0)
    plot.show(
        fig,
        "Computed and printed points of one photo, joined by lines. They differ by up"
        f" to {apart[0]:.5f} mm in x and {apart[1]:.1f} mm in y.",
    )


# --- Figures of a round target and its centroid: what pulls it, and how good it is ---

COLOURS = (plot.BLUE, plot.RED, plot.GREEN)
PLACE = (20.3, 19.6)  # of the target of `target_by_hand`, px
SIDE = 41  # px, its photo


def target_pull(
    window: np.ndarray, truth: np.ndarray, centroids: dict[str, np.ndarray]
) -> None:
    """Show a target in its window, and centroids of it with the truth."""
    fig, ax = plt.subplots(figsize=(6.0, 4.6))
    ax.imshow(window, vmin=0, vmax=255)
    middle = (np.array(window.shape[::-1]) - 1) / 2
    ax.plot(*middle, "x", color=plot.ORANGE, markersize=13, markeredgewidth=3)
    ax.plot([], [], "x", color=plot.ORANGE, mew=3, label="centre of the window")
    ax.plot(*truth, "+k", markersize=26, markeredgewidth=3, label="truth")
    for (name, at), marker, colour in zip(centroids.items(), "os^", COLOURS):
        ax.plot(*at, marker, color=colour, markersize=11, label=name)
    ax.grid(False)
    ax.set(xlabel="column X (px)", ylabel="row Y (px)")
    ax.set(yticks=range(0, len(window), 4))
    fig.legend(loc="outside lower center", ncols=2)
    told = [f"{name} at {_at(at)}" for name, at in centroids.items()]
    words = f"A bright disc in its window, its true centre at {_at(truth)}"
    plot.show(fig, f"{words}; {', '.join(told)} px.", colours=64)


def target_by_hand() -> None:
    """Show a target with sliders for the window, and for the subtracted background."""
    import ipywidgets

    clean = simulate.target(PLACE, 8.0, (SIDE, SIDE), background=40.0)
    photo = simulate.photograph(clean, noise=4.0, seed=2, bits=8)

    def draw(size: int, shift: int, background: int) -> None:
        low = SIDE // 2 - size // 2
        part = photo[low : low + size, low + shift : low + shift + size].astype(float)
        weight = part - background
        i, j = np.indices(part.shape)
        moments = (j * weight).sum(), (i * weight).sum()
        at = np.array(moments) / weight.sum() + (low + shift, low)
        off = at - PLACE
        fig, axes = plt.subplots(1, 2, figsize=(10, 4.6))
        frame: Look = {"fill": False, "edgecolor": plot.ORANGE, "linewidth": 3}
        corner = (low + shift - 0.5, low - 0.5)
        for ax in axes:
            _target(ax, photo, at)
        axes[0].add_patch(plt.Rectangle(corner, size, size, **frame))
        axes[0].set(title="photo and window", xlabel="column X (px)")
        axes[0].set_ylabel("row Y (px)")
        near = (PLACE[0] - 6, PLACE[0] + 6), (PLACE[1] + 6, PLACE[1] - 6)
        axes[1].set(xlim=near[0], ylim=near[1], xlabel="column X (px)")
        axes[1].set_title(f"off by {_sign(off[0])}, {_sign(off[1])} px")
        fig.legend(*axes[0].get_legend_handles_labels(), loc="outside right upper")
        plot.show(
            fig,
            f"A target, its window of {size} px moved by {shift} px, background"
            f" {background} subtracted: the centroid is off by {_sign(off[0])},"
            f" {_sign(off[1])} px.",
            colours=64,
        )

    look: Look = {"continuous_update": False}
    interact(
        draw,
        size=ipywidgets.IntSlider(21, 15, 27, 2, description="window", **look),
        shift=ipywidgets.IntSlider(4, -6, 6, description="moved", **look),
        background=ipywidgets.IntSlider(0, 0, 40, 5, description="subtracted", **look),
    )


def target_precision() -> None:
    """Show how precise a centroid is, simulated and predicted, with noise 3."""
    fig, axes = plt.subplots(1, 2, figsize=(5.7, 3.8), sharey=True)
    studies = (
        ("diameter (px)", [(d, d, 21) for d in (4, 6, 8, 10, 12)]),
        ("window (px)", [(size, 8, size) for size in (15, 21, 31, 41)]),
    )
    told = []
    for ax, (label, cases) in zip(axes, studies):
        for sigmas, line, fill, name in ((0, "-", None, "no"), (3, ":", "white", "3σ")):
            runs = [(at, *target_sampled(d, size, sigmas)) for at, d, size in cases]
            places, simulated, predicted = np.transpose(runs)
            colour = plot.RED if sigmas else plot.BLUE
            ax.plot(places, predicted, line, color=colour)
            ax.plot(places, simulated, "o", color=colour, mfc=fill or colour)
            ax.plot(
                [], [], f"o{line}", color=colour, mfc=fill, label=f"{name} threshold"
            )
            each = ", ".join(f"{s:.3f} at {p:.0f}" for p, s in zip(places, simulated))
            told.append(f"{label}, {name} threshold: {each}")
        ax.axhline(0.03, color=plot.BLACK, linestyle="--")
        ax.set(xlabel=label, yscale="log")
        ax.set(yticks=(0.01, 0.03, 0.1), yticklabels=("0.01", "0.03", "0.10"))
        ax.minorticks_off()
    axes[0].set(ylabel="standard deviation (px)", title="window 21 px")
    axes[0].set_xticks(range(4, 13, 2))
    axes[1].set_title("diameter 8 px")
    handles = axes[0].get_legend_handles_labels()
    fig.legend(*handles, loc="outside lower center", ncols=2)
    words = "Standard deviation of a centroid in px, simulated and predicted. "
    plot.show(fig, words + "; ".join(told) + ". A dashed line marks 0.03 px.")


def target_sampled(
    diameter: float, size: int, sigmas: float = 0.0
) -> tuple[float, float]:
    """Precision of the centroid of 200 simulated targets: sampled and predicted (px).

    The threshold is `sigmas` standard deviations of the noise, of 3 grey values.
    """
    noise = 3.0
    shift = np.random.default_rng(2013).uniform(-0.5, 0.5, (200, 2))
    centres = (size - 1) / 2 + shift
    clean = simulate.target(centres, diameter, shape=(size, size))
    noisy = simulate.photograph(clean, noise, seed=15, bits=8)
    found = image.centroid(noisy, sigma=noise, threshold=sigmas * noise)
    predicted = np.sqrt(np.nanmean(found.covariance[:, 0, 0]))
    return float(np.nanstd(found.position - centres)), float(predicted)


def _target(ax: Axes, photo: np.ndarray, at: np.ndarray) -> None:
    ax.imshow(photo, vmin=0, vmax=255)
    ax.plot(*PLACE, "+k", markersize=24, markeredgewidth=3, label="truth")
    ax.plot(*at, "s", color=plot.RED, markersize=10, label="centroid")
    ax.grid(False)


def _at(point: np.ndarray) -> str:
    return f"({point[0]:.2f}, {point[1]:.2f})"


def _sign(value: float) -> str:
    return f"{value:+.2f}".replace("-", "−")
