"""Figures of lesson 9: a board that is not flat, a pair, and its surface."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from scipy.spatial import Delaunay, cKDTree

from pgm_book.ch09.photos import Board, Pair
from pgm_lab import plot
from pgm_lab.plot.basic import Look, interact
from pgm_lab.plot.space import fit, space

ENLARGED = 50.0  # arrows of the board's points
EDGE = 0.1  # m: a triangle with a longer side is not drawn
FRONT = 1.3  # times the median depth: what lies behind is not drawn
WORDS: Look = {"fontsize": 15}


# --- How flat is your board? ---


def boards(sets: tuple[Board, Board]) -> None:
    """Show the first photo of each set, with the corners that were found."""
    fig, axes = plt.subplots(1, 2, figsize=(10, 3.5), layout="compressed")
    for ax, seen in zip(axes, sets):
        _bare(ax, seen.photo, f"{seen.name}: {len(seen.pixels)} photos")
        ax.plot(*seen.pixels[0].T, "+", color=plot.ORANGE, ms=9, mew=2)
    n = len(sets[0].grid)
    plot.show(
        fig,
        f"Two photos of one chequerboard; a cross marks each of its {n} inner corners.",
        dpi=160,
        colours=48,
    )


def shapes(sets: tuple[Board, Board], off: list[np.ndarray]) -> None:
    """Map how far two sets of photos find the board off its plane and its grid."""
    fig, axes = plt.subplots(1, 2, figsize=(7, 3.3), layout="compressed")
    most = max(np.abs(one[:, 2]).max() for one in off)
    for ax, seen, one in zip(axes, sets, off):
        x, y, _ = seen.grid.T
        levels = np.linspace(-most, most, 15)
        drawn = ax.tricontourf(x, y, one[:, 2], levels, cmap="PuOr")
        ax.quiver(
            x, y, *(ENLARGED * one[:, :2].T), angles="xy", scale_units="xy", scale=1,
            width=0.009, color=plot.BLACK,
        )  # fmt: skip
        ax.set_title(f"from the {seen.name}", fontsize=15)
        ax.set(aspect="equal", xticks=[], yticks=[])
        ax.set(xlim=(x.min() - 0.6, x.max() + 0.6))
        ax.set(ylim=(y.min() - 0.6, y.max() + 0.6))
        ax.grid(False)
    bar = fig.colorbar(drawn, ax=axes, location="bottom", shrink=0.7, aspect=30)
    bar.set_ticks([-round(most, 3), 0, round(most, 3)])
    said = f"towards the camera (squares); arrows: in the plane, × {ENLARGED:g}"
    bar.set_label(said, fontsize=13)
    r = [float(np.corrcoef(a, b)[0, 1]) for a, b in zip(off[0].T, off[1].T)]
    plot.show(
        fig,
        "Two maps of the same board, one from each set of photos: colours say how far"
        f" each corner is off the plane, up to {most:.3f} squares, arrows, {ENLARGED:g}"
        " times enlarged, how far off its place in the grid. The maps look alike: r ="
        f" {r[0]:.2f}, {r[1]:.2f}, {r[2]:.2f} in x, y, z.",
        dpi=160,
        colours=64,
    )


def held_out(errors: dict[str, np.ndarray]) -> None:
    """Show what is left in each photo that took no part, a column for each model."""
    fig, ax = plt.subplots(figsize=(7, 3.1), layout="constrained")
    said = []
    for k, (name, values) in enumerate(errors.items()):
        colour = (plot.RED, plot.BLUE)[k % 2]
        ax.plot(k + np.linspace(-0.2, 0.2, len(values)), values, "o", color=colour)
        mean = float(np.sqrt(np.mean(np.square(values))))
        ax.plot((k - 0.3, k + 0.3), (mean, mean), color=plot.BLACK, lw=3)
        said.append(f"{name}: {mean:.3f} px")
    ax.set_xticks(range(len(errors)), list(errors))
    ax.set(
        ylabel="what is left (px, RMS)", xlim=(-0.5, len(errors) - 0.5), ylim=(0, None)
    )
    ax.grid(axis="x")
    plot.show(
        fig,
        "What is left in x and y in each photo that took no part, a dot a photo, for"
        f" two models; their root mean squares are bars. {'; '.join(said)}.",
        dpi=160,
        colours=48,
    )


# --- Where did the second photo stand? ---


def pair(scene: Pair) -> None:
    """Show both photos, and between which points a distance was measured."""
    fig, axes = plt.subplots(1, 2, figsize=(10, 3.4), layout="compressed")
    for ax, photo, name in zip(axes, (scene.left, scene.right), ("left", "right")):
        _bare(ax, photo, f"{name}, {photo.shape[1]} × {photo.shape[0]} px")
    axes[0].plot(*scene.ends.T, "o-", color=plot.ORANGE, mfc="none", ms=11, mew=2.5)
    plot.show(
        fig,
        "Two photos of the same scene, taken side by side and looking in different"
        f" directions. A line on the left one joins two points {scene.distance:.3f} m"
        " apart.",
        dpi=160,
        colours=64,
    )


def matches(scene: Pair, found: np.ndarray) -> None:
    """Show where the matched points lie in both photos, joined by lines."""
    fig, ax = plt.subplots(figsize=(10, 3.4), layout="compressed")
    columns = scene.size[0]
    _bare(ax, np.hstack([scene.left, scene.right]), f"{len(found)} matched points")
    colours = plt.get_cmap("viridis")(found[:, 1] / scene.size[1])
    for one, colour in zip(found, colours):
        ends = (one[0], one[2] + columns), one[[1, 3]]
        ax.plot(*ends, "o-", color=colour, lw=0.8, ms=4)
    plot.show(
        fig,
        f"The left and the right photo side by side, {len(found)} points joined by"
        " lines with their matches; nearly all lines run side by side.",
        dpi=160,
        colours=96,
    )


def weakest(names: list[str], sd: np.ndarray, off: np.ndarray) -> None:
    """Show the standard deviations of a relative orientation, and its true errors."""
    fig, ax = plt.subplots(figsize=(7, 3.1), layout="constrained")
    at = np.arange(len(names))
    ax.bar(at, sd, color=plot.BLUE, width=0.6, label="standard deviation")
    if np.isfinite(off).all():
        ax.plot(at, np.abs(off), "D", color=plot.ORANGE, ms=11, label="true error")
    ax.set_xticks(at, names)
    ax.set(ylabel="degrees")
    ax.grid(axis="x")
    ax.legend(fontsize=13, loc="upper left")
    said = [f"{name} {value:.3f}°" for name, value in zip(names, sd)]
    plot.show(
        fig,
        f"Bars: the standard deviations of the orientation, {', '.join(said)};"
        " diamonds, where the truth is known, its errors.",
        dpi=160,
        colours=48,
    )


# --- What shape is it? ---


def depths(
    image: np.ndarray,
    places: np.ndarray,
    Z: np.ndarray,
    sd: np.ndarray,
    true: np.ndarray,
) -> None:
    """Map depths on the left normal image, and their errors in units of their sd.

    Where no truth is known, it is NaN, and the sd itself takes the place of the errors.
    """
    fig, axes = plt.subplots(2, 1, figsize=(7, 6.2), layout="compressed")
    off = (Z - true) / sd
    kept, known = np.isfinite(Z), np.isfinite(off)
    low, high = places.min(axis=0) - 10, places.max(axis=0) + 10
    below: tuple = (off, "error / sd", {"cmap": "RdBu", "vmin": -4, "vmax": 4})
    said = "their standard deviation."
    if known.any():
        share = 100 * np.mean(np.abs(off[known]) <= 3)
        # 1 if the predicted standard deviations are true; wrong matches hardly count
        typical = np.median(np.abs(off[known])) / 0.6745
        axes[1].set_xlabel(f"typical error: {typical:.2f} sd", fontsize=18)
        said = (
            f"their error over its standard deviation, typically {typical:.2f}."
            f" {share:.0f} % lie within three standard deviations; the others are"
            " edges, spokes and repeated things."
        )
    else:
        below = (1000 * sd, "sd (mm)", {"cmap": "cividis_r"})
    above: tuple = (-Z, "depth (m)", {"cmap": "viridis_r"})
    for ax, (values, name, look) in zip(axes, (above, below)):
        _bare(ax, image, "")
        drawn = ax.scatter(*places[kept].T, c=values[kept], s=9, marker="s", **look)
        bar = fig.colorbar(drawn, ax=ax)
        bar.set_label(name, fontsize=18)
        bar.ax.tick_params(labelsize=18)
        ax.set(xlim=(low[0], high[0]), ylim=(high[1], low[1]))
    plot.show(
        fig,
        f"The left normal image with {kept.sum()} measured places: above, coloured by"
        f" their depth; below, by {said}",
        dpi=120,
        colours=128,
    )


def surface(points: np.ndarray, grey: np.ndarray) -> None:
    """Show its front, to be turned by two sliders; without a kernel, one view.

    A point off the depth of its neighbours is left out, and so is what lies behind.
    """
    from ipywidgets import IntSlider

    seen = points[:, :2] / -points[:, 2:]  # as the left camera sees them
    _, near = cKDTree(seen).query(seen, 9)
    depth = -points[:, 2]
    typical = np.median(depth[near], axis=1)
    shown = (np.abs(depth - typical) < EDGE / 2) & (depth < FRONT * np.median(depth))
    points, grey = points[shown], grey[shown]
    mesh = Delaunay(seen[shown]).simplices
    mesh = mesh[np.ptp(points[mesh], axis=1).max(axis=1) < EDGE]
    colours = plt.get_cmap("bone")((grey[mesh].mean(axis=1) / 255) ** 0.6)
    X, Y, Z = points.T

    def draw(azimuth: int, elevation: int) -> None:
        fig = plt.figure(figsize=(7, 3.9))
        ax = space(fig, view=(elevation, azimuth), zoom=1.6)
        fit(ax, np.column_stack([X, -Z, Y])[mesh], zoom=1.6)
        drawn = ax.plot_trisurf(X, -Z, Y, triangles=mesh, lw=0, antialiased=False)
        drawn.set_clip_on(False)
        drawn.set_facecolors(colours)
        ax.set_title(f"azimuth {azimuth}°, elevation {elevation}°", fontsize=16)
        plot.show(
            fig,
            f"A surface of {len(mesh)} triangles in grey values of the photo, seen from"
            f" azimuth {azimuth}° and elevation {elevation}°.",
            dpi=160,
            colours=48,
        )

    interact(
        draw,
        azimuth=IntSlider(-70, -150, -30, 5, continuous_update=False),
        elevation=IntSlider(25, -10, 80, 5, continuous_update=False),
    )


def _bare(ax: Axes, image: np.ndarray, title: str) -> None:
    """Draw an image without numbers at its edges."""
    ax.imshow(image, cmap="gray", vmin=0, vmax=255)
    ax.set(xticks=[], yticks=[])
    ax.set_title(title, **WORDS)
    ax.grid(False)
