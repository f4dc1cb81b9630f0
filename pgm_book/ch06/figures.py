"""Figures of a camera that calibrates itself: one ray, its lens, its photos."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from pgm_book.program import bundle as textbook
from pgm_book.program.camera import derivatives
from pgm_lab import bundle, plot
from pgm_lab.plot import space
from pgm_lab.plot.basic import Look, interact
from pgm_lab.plot.space import best_view, fill

C = 35.0  # mm, of the sketches
# Drawn so large that they can be seen; the order is that of a camera's parameters
LARGE = {"K1": 6e-4, "P1": 4e-3, "b1": 0.12, "b2": 0.12}
WORDS = {"K1": "radial", "P1": "decentring", "b1": "affinity", "b2": "shear"}
NAMES = ["c", "x0", "y0", "K1", "K2", "K3", "P1", "P2", "b1", "b2"]
MOTIONS = (
    *(f"shift in {axis}" for axis in "XYZ"),
    *(f"rotation about {axis}" for axis in "XYZ"),
    "scale",
)


# --- One ray, nineteen unknowns ---


def ray() -> None:
    """Draw one ray with its point, photo and camera, and count their unknowns."""
    fig, ax = plt.subplots(figsize=(10, 5.4), layout="constrained")
    centre, target = np.array([0.0, 3.0]), np.array([5.0, -1.6])
    along = np.array([0.97, -0.24])  # the axis of the camera
    across = np.array([-along[1], along[0]])
    foot = centre + 2.4 * along
    meets = centre + (target - centre) * 2.4 / ((target - centre) @ along)
    plane = np.array([foot - 2.6 * across, foot + 1.2 * across])
    ax.plot(*plane.T, lw=4, color=plot.BLACK)
    axis = np.array([centre, centre + 3.2 * along])
    ax.plot(*axis.T, "--", color=plot.GREY, lw=2)
    ax.plot(*np.array([centre, target]).T, color=plot.BLUE, lw=3)
    for place, colour in (
        (centre, plot.BLACK),
        (meets, plot.RED),
        (target, plot.GREEN),
        (foot, plot.GREY),
    ):
        ax.plot(*place, "o", color=colour, ms=14, zorder=3)
    for words, (x, y), colour in (
        ("perspective centre", centre + (-1.6, 0.35), plot.BLACK),
        ("principal point", foot + (0.25, 0.2), plot.GREY),
        ("image plane", plane[1] + (-0.7, 0.2), plot.BLACK),
        ("$c$", centre + 1.2 * along + (0, 0.2), plot.GREY),
        ("image point:\n2 observations, $x, y$", meets + (-3.6, -0.7), plot.RED),
        ("target", target + (0.3, -0.1), plot.GREEN),
    ):
        ax.text(x, y, words, fontsize=16, color=colour)
    for words, height, colour in (
        (
            "photo: 6 unknowns\n$X_0, Y_0, Z_0, \\omega, \\varphi, \\kappa$",
            4.3,
            plot.BLACK,
        ),
        (
            "camera: 10 unknowns\n$c, x_0, y_0, K_1, K_2, K_3,$\n$P_1, P_2, b_1, b_2$",
            2.3,
            plot.RED,
        ),
        ("target: 3 unknowns\n$X, Y, Z$", 0.4, plot.GREEN),
    ):
        box = {"boxstyle": "round", "fc": "white", "ec": colour, "lw": 2.5}
        ax.text(5.2, height, words, fontsize=16, va="center", bbox=box)
    ax.set(xlim=(-1.8, 8.6), ylim=(-2.1, 5.0), aspect="equal")
    ax.axis("off")
    plot.show(
        fig,
        "One ray from a target through the image plane to the perspective centre. The"
        " principal point and c are marked. Three boxes count the unknowns: the target"
        " has 3, the photo 6, the camera 10; the image point gives 2 observations.",
    )


def lens_grids() -> None:
    """Draw what each of K1, P1, b1 and b2 does to a grid of image points."""
    fig, axes = plt.subplots(1, 4, figsize=(10, 3.5), layout="constrained")
    for ax, (name, value) in zip(axes, LARGE.items()):
        camera = np.zeros(10)
        camera[0], camera[NAMES.index(name)] = C, value
        _grid(ax, camera)
        symbol = f"${name[0]}_{name[1]}$"
        ax.set_title(f"{symbol}, {WORDS[name]}", fontsize=17, loc="center")
        ax.axis("off")
    plot.show(
        fig,
        "A square grid, and what each parameter makes of it, drawn much too large. K1"
        " pulls the corners outwards, P1 pushes one side more than the other, b1"
        " stretches x, b2 turns the square into a rhomboid.",
    )


def _grid(ax: Axes, camera: np.ndarray) -> None:
    """Draw a grid of image points, and where the camera's lens moves it."""
    x, y = np.meshgrid(np.linspace(-10, 10, 9), np.linspace(-7.5, 7.5, 7))
    moved = textbook.without_lens(np.column_stack([x.ravel(), y.ravel()]), camera)
    u, v = moved.T.reshape(2, *x.shape)
    for across, up, colour, width in ((x, y, "0.7", 1.2), (u, v, plot.BLUE, 2.2)):
        ax.plot(across, up, color=colour, lw=width)
        ax.plot(across.T, up.T, color=colour, lw=width)
    ax.set_aspect("equal")
    ax.grid(False)


# --- How many equations, how many unknowns? ---


def zeros(photos: np.ndarray, points: np.ndarray) -> None:
    """Show what is not zero in the normal matrix of rays from photos to points."""
    groups = {"camera": np.zeros(10, int)}
    groups["photos"] = 1 + np.repeat(np.arange(photos.max() + 1), 6)
    groups["points"] = 1 + photos.max() + 1 + np.repeat(np.arange(points.max() + 1), 3)
    owner = np.concatenate(list(groups.values()))
    meet = np.eye(owner.max() + 1, dtype=bool)
    meet[0] = meet[:, 0] = True  # the camera takes part in every ray
    row, column = 1 + photos, 2 + photos.max() + points
    meet[row, column] = meet[column, row] = True
    full = meet[np.ix_(owner, owner)]
    fig, ax = plt.subplots(figsize=(7, 4.6), layout="constrained")
    ax.imshow(full, cmap=ListedColormap(["white", plot.BLUE]), interpolation="nearest")
    ends = np.cumsum([len(part) for part in groups.values()])
    names = [f"{name} {len(part)}" for name, part in groups.items()]
    middles = ends - [len(part) / 2 for part in groups.values()]
    ax.set_yticks(middles, names)
    ax.set_xticks([])
    ax.tick_params(length=0)
    ax.grid(False)
    for end in ends[:-1] - 0.5:
        ax.axhline(end, color=plot.GREY, lw=1)
        ax.axvline(end, color=plot.GREY, lw=1)
    share = 100 * (1 - full.mean())
    ax.set_title(f"{share:.0f} % of the normal matrix is zero")
    plot.show(
        fig,
        f"The normal matrix of {len(full)} unknowns, what is not zero in blue: full"
        " bands for the camera, full blocks where photos meet points, small blocks for"
        " each photo and each point on the diagonal. All else is empty:"
        f" {share:.0f} per cent.",
    )


# --- Which motions does no photo show? ---


def motions(exteriors: np.ndarray, points: np.ndarray) -> None:
    """Show the seven motions of a network that no photo notices."""
    fig = _seven_motions(exteriors, points)
    fig.set_size_inches(7, 4.0)
    for text in [*fig.texts, *(text for ax in fig.axes for text in ax.texts)]:
        text.set_fontsize(13)
    plot.show(
        fig,
        "Seven small pictures of the network with arrows at cameras and points: shifts"
        " in X, Y and Z, rotations about X, Y and Z, and a scale. In each, cameras and"
        " points move together. The axes X, Y and Z stand beside them.",
    )


def _seven_motions(exteriors: np.ndarray, points: np.ndarray) -> Figure:
    """Draw the seven motions of a whole network that no photo notices.

    Grey is the network as it stands, arrows lead cameras and points along each of the
    seven columns of G; their lengths compare within a panel only.
    """
    positions = np.concatenate([exteriors[:, :3], points])
    reach = np.ptp(positions, axis=0).max()
    fig = plt.figure(figsize=(13, 6.8), layout="none")
    m = len(exteriors)
    # About a point between cameras and object, or one of them would hardly move
    centre = (positions[:m].mean(axis=0) + points.mean(axis=0)) / 2
    everything = bundle.motions(positions, centre)
    lengths = np.linalg.norm(everything, axis=2).max(axis=1)
    steps = 0.24 * reach * everything / lengths[:, None, None]
    room = np.concatenate([positions, *(positions + steps)])
    view = best_view(exteriors[:, :3], points)
    for number, (name, step) in enumerate(zip(MOTIONS, steps)):
        # Shifts above, rotations below, the scale at their right in the middle
        row, column = divmod(number, 3) if number < 6 else (0.5, 3)
        where = (0.245 * column, 0.5 - 0.5 * row, 0.26, 0.44)
        ax = space.space(fig, view=view)
        look: Look = {"axes": False, "color": plot.GREY}
        for exterior in exteriors:
            space.draw_camera(ax, exterior, 0.13 * reach, **look)
        ax.plot(*points.T, "o", color=plot.GREY, markersize=3.5, **space.FREE)
        some = slice(m, None, -(-len(points) // 12))  # a dozen of the points is enough
        for at, color, wide in ((some, plot.BLUE, 2.0), (slice(m), plot.RED, 3.2)):
            arrows: Look = {"linewidth": wide, "arrow_length_ratio": 0.3, "zorder": 5}
            arrows |= space.FREE | {"color": color}
            ax.quiver(*positions[at].T, *step[at].T, **arrows)
        fill(ax, room, where)
        fig.text(where[0] + 0.13, where[1] + 0.45, name, fontsize=20, ha="center")
    ax = space.space(fig, view=view)
    tips = space.draw_axes(ax, (0, 0, 0), names=("X", "Y", "Z"), fontsize=18)
    for drawn in (*ax.collections, *ax.texts):
        drawn.set_color(plot.BLACK)  # orange and blue are cameras and points here
    fill(ax, 1.3 * np.vstack([np.zeros(3), tips]), (0.81, 0.78, 0.11, 0.18))
    for y, word, color in ((0.16, "cameras", plot.RED), (0.1, "points", plot.BLUE)):
        fig.text(0.865, y, word, fontsize=19, color=color, ha="center")
    return fig


# --- Your bundle adjustment ---


def which_photos(given: bundle.Network) -> None:
    """Show how well c is determined by photos that are chosen from a list."""
    import ipywidgets

    whole = bundle.adjust(given)
    numbers = range(1, len(whole.exteriors) + 1)

    def draw(photos: tuple[int, ...]) -> None:
        chosen = np.isin(numbers, photos)
        try:
            one = bundle.adjust(given.only(np.flatnonzero(chosen)))
        except ValueError as reason:
            print(f"these photos do not do: {reason}")
            return
        sd = 1000 * one.sd_interior[0] * whole.sigma0 / one.sigma0  # µm
        panels: Look = {"layout": "constrained", "sharey": True}
        fig, axes = plt.subplots(
            1, 2, figsize=(7, 4.4), width_ratios=(1, 2.7), **panels
        )
        for ax, across, name in zip(axes, (0, 2), ("from above", "from the side")):
            _stations(ax, whole.exteriors[:, [across, 1]], chosen)
            ax.plot(*whole.points[:, [across, 1]].T, ".", color=plot.GREY, ms=5)
            ax.set(aspect="equal", title=name, xlabel=f"{'XYZ'[across]} (mm)")
            ax.margins(0.15)
        words: Look = {"textcoords": "offset points", "fontsize": 13, "ha": "center"}
        for place, names in _by_place(whole.exteriors[:, [2, 1]]):
            axes[1].annotate(", ".join(names), (place[0], place[1]), (0, 11), **words)
        axes[0].set(ylabel="Y (mm)", xticks=[0], xlim=(-260, 330), ylim=(-250, 1900))
        fig.suptitle(f"standard deviation of c: {sd:.0f} µm", fontsize=17)
        plot.show(
            fig,
            "The network from above and from the side, in one scale: targets, and"
            f" stations at five places. Photos {', '.join(map(str, photos))} are used;"
            f" the standard deviation of c is {sd:.0f} micrometres.",
        )

    choice = ipywidgets.SelectMultiple(
        options=list(numbers), value=list(numbers), description="photos", rows=9
    )
    interact(draw, photos=choice)


def _stations(ax: Axes, places: np.ndarray, chosen: np.ndarray) -> None:
    """Draw stations, used or left out."""
    look: Look = {"ms": 13, "mec": plot.BLUE, "color": plot.BLUE}
    ax.plot(*places[chosen].T, "^", **look)
    ax.plot(*places[~chosen].T, "^", **look | {"color": "white"})


def _by_place(stations: np.ndarray) -> list[tuple[np.ndarray, list[str]]]:
    """Places (2,) of stations that lie apart in the drawing, with their numbers."""
    found: list[tuple[np.ndarray, list[str]]] = []
    for number, station in enumerate(stations, 1):
        near = [b for a, b in found if np.hypot(*(station - a)) < 150]
        names = near[0] if near else []
        names.append(str(number))
        if not near:
            found.append((station, names))
    return found


# --- How well is the lens known? ---


def curve(result: bundle.Bundle) -> None:
    """Show the radial correction of the lens with its band, and the radii measured."""
    fig = plot.bundle.lens_curve(result)
    fig.set_size_inches(7, 4.9)
    lens, band = result.cameras[0], fig.axes[1]
    radii = np.hypot(*(result.network.xy - (lens.x0, lens.y0)).T)
    look: Look = {"color": plot.BLACK, "markeredgewidth": 1, "markersize": 12}
    look["transform"] = band.get_xaxis_transform()
    band.plot(radii, np.full(len(radii), 0.06), "|", **look)
    (words,) = band.texts
    words.set_text(f"yellow: as far as the {len(radii)} rays (strokes) reach ")
    far = [int(np.sum(radii > mm)) for mm in (7, 8)]
    plot.show(
        fig,
        "Above: the radial correction of the lens against the distance from the"
        " principal point, with its 95 per cent band. Below: half the width of the"
        " band, below 1 micrometre up to 6 millimetres, 2 at 10 millimetres, and"
        " opening quickly beyond the last measured point. Strokes mark the radii of"
        f" the rays: {far[0]} lie beyond 7 and {far[1]} beyond 8 millimetres.",
    )


def over_the_image(result: bundle.Bundle) -> None:
    """Map the standard deviation of the correction, and show all residuals."""
    camera, C = result.interior, result.covariance_interior
    x, y = np.meshgrid(np.linspace(-10, 10, 41), np.linspace(-7.5, 7.5, 31))
    grid = np.column_stack([x.ravel(), y.ravel()])
    J = derivatives(lambda some: textbook.without_lens(grid, some), camera)
    J = J.reshape(-1, 2, 10)[..., 3:]  # of the lens
    sd = 1000 * np.sqrt(np.einsum("nij,jk,nik->n", J, C[3:, 3:], J)).reshape(x.shape)
    xy, v = result.network.xy, result.residuals
    panels: Look = {"layout": "constrained", "sharey": True}
    fig, (left, right) = plt.subplots(1, 2, figsize=(10, 4.3), **panels)
    left.plot(*xy.T, ".", color=plot.GREY, ms=4)
    arrows: Look = {"angles": "xy", "scale_units": "xy", "scale": 1e-3, "width": 0.004}
    left.quiver(*xy.T, *v.T, color=plot.RED, **arrows)
    left.set_title("residuals, 1000 times as long")
    lines = right.contour(x, y, sd, (0.25, 0.5, 1, 2, 4, 8), colors=plot.BLUE)
    right.plot(*xy.T, ".", color=plot.GREY, ms=4)
    for words in right.clabel(lines, fmt="%g µm", fontsize=13, zorder=3):
        words.set_bbox({"facecolor": "white", "edgecolor": "none", "pad": 1})
    right.set_title("standard deviation of the correction")
    for ax in (left, right):
        ax.set(aspect="equal", xlim=(-10, 10), ylim=(-7.5, 7.5), xlabel="x (mm)")
        ax.set_xticks((-8, -4, 0, 4, 8))
        ax.grid(False)
    left.set_ylabel("y (mm)")
    middle, edge = sd[12:19, 17:24].max(), sd[[0, 0, -1, -1], [0, -1, 0, -1]]
    plot.show(
        fig,
        f"Two pictures of the image, 20 by 15 mm, with {len(xy)} image points, dense in"
        " the middle and none in the corners. Left, their residuals in all directions,"
        " most below half a micrometre. Right, lines of equal standard deviation of the"
        f" lens correction: below {middle:.2f} µm in the middle, {edge.min():.0f} to"
        f" {edge.max():.0f} µm in the corners.",
    )


# --- Precision is not accuracy ---


def halves(found: dict[str, tuple[float, float]]) -> None:
    """Show a principal distance with one and two standard deviations, by photos."""
    fig, ax = plt.subplots(figsize=(7, 2.9), layout="constrained")
    for row, (c, sd) in enumerate(found.values()):
        for wide, width in ((2, 2.5), (1, 9)):
            ax.hlines(-row, c - wide * sd, c + wide * sd, color=plot.BLUE, lw=width)
        ax.plot(c, -row, "o", color="white", mec=plot.BLACK, ms=10, zorder=3)
    ax.set_yticks(-np.arange(len(found)), found)
    ax.set(xlabel="c (mm), ± one and two standard deviations")
    ax.set_ylim(0.6 - len(found), 0.6)
    values = "; ".join(f"{k}: {c:.3f} ± {sd:.3f}" for k, (c, sd) in found.items())
    plot.show(fig, f"Principal distances in mm with standard deviations. {values}.")


def wrong_control(x: np.ndarray, predicted: np.ndarray, moved: np.ndarray) -> None:
    """Show what an error x of one control point does, and what the adjustment says.

    Predicted standard deviation and shift are RMS of the other points, all in mm.
    """
    fig, ax = plt.subplots(figsize=(7, 4.4), layout="constrained")
    ax.plot(x, moved, "o-", color=plot.RED, lw=3, label="shift of the other points")
    text = "their standard deviation"
    ax.plot(x, predicted, "s--", color=plot.BLUE, lw=3, label=text)
    ax.set(xlabel="error of one control point (mm)", ylabel="RMS (mm)", ylim=(0, None))
    ax.legend(loc="upper left")
    plot.show(
        fig,
        "Against the error of one control point up to"
        f" {x[-1]:g} mm: it shifts the other points by up to {moved[-1]:.2f} mm, their"
        f" standard deviation stays at {predicted[-1]:.2f} mm.",
    )
