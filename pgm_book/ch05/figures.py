"""Sketches of rays in space: one, two in a plane, a model that goes to the ground."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import FancyArrowPatch
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from pgm_lab import orientation, plot, rotation
from pgm_lab.camera import Camera, project
from pgm_lab.plot import space
from pgm_lab.plot.basic import Look, interact
from pgm_lab.plot.space import fill

CAMERA = np.array([0.0, 0, 3.4, 0.12, -0.1, 0.0])  # of the sketch of one ray
PAIR = np.array([(-1.3, 0, 3.0, 0.1, -0.3, 0), (1.3, 0, 3.2, 0.05, 0.25, 0)])
TEXT = 15
FRONT: Look = {"zorder": 7} | space.FREE
THICK: Look = {"linewidth": 3, "zorder": 5} | space.FREE
HOUSE = np.array(
    [(0, 0, 0), (4, 0, 0), (4, 3, 0), (0, 3, 0), (0, 0, 2.5), (4, 0, 2.5)]
    + [(4, 3, 2.5), (0, 3, 2.5), (0, 1.5, 3.8), (4, 1.5, 3.8)]
)
EDGES = (
    *((0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 5), (2, 6), (3, 7)),
    *((4, 5), (6, 7), (4, 8), (8, 7), (5, 9), (9, 6), (8, 9)),
)
CONTROL = (0, 1, 2, 8)  # corners whose ground coordinates are known
HEIGHT, C, SIGMA = 120.0, 35.0, 0.003  # m, mm, mm: of the sliders
FAR, NEAR = 10.0, Camera(35.0)  # m, and the camera: of the clouds
ANGLES = (10, 40, 90, 150)
BASES = (20, 160)  # m


# --- What does one ray determine? ---


def one_ray() -> None:
    """Show one collinear ray with all its parts named."""
    fig = plt.figure(figsize=(10, 5.0), layout="none")
    ax = space.space(fig, view=(12, -68))
    M, centre, size = rotation.matrix(*CAMERA[3:]), CAMERA[:3], 1.35
    drawn = [*space.draw_camera(ax, CAMERA, size, axes=False, color=plot.GREY)]
    U, V, W = 1.15, 0.75, -3.1
    steps = centre + np.cumsum([(0, 0, 0), (0, 0, W), (U, 0, 0), (0, V, 0)], 0) @ M
    scale = -size / W
    small = (
        centre
        + np.cumsum([(0, 0, 0), (0, 0, -size), (scale * U, 0, 0), (0, scale * V, 0)], 0)
        @ M
    )
    ax.plot(*np.array([centre, steps[-1]]).T, color=plot.RED, **THICK)
    for corners, colour in ((steps, plot.BLUE), (small, plot.BLACK)):
        ax.plot(*corners.T, color=colour, linewidth=2, linestyle="--", zorder=4)
    ax.plot(*small[-1], "o", color=plot.RED, markersize=9, zorder=6)
    ax.plot(*steps[-1], "s", color=plot.BLUE, markersize=9, zorder=6)
    ax.plot(*small[1], "+", color=plot.BLACK, markersize=14, mew=2.5, zorder=6)
    # W counts from the perspective centre on, and points away from +z
    beside = np.array([centre, steps[1]]) - 0.22 * M[0]
    ax.quiver(*beside[0], *(W * M[2]), color=plot.BLUE, lw=2, arrow_length_ratio=0.06)
    for at, words, colour, where in (
        (
            centre - 0.25 * M[0],
            "perspective centre   \n$(X_0, Y_0, Z_0)$  ",
            plot.BLACK,
            "right",
        ),
        (
            small[1] + 0.25 * (steps[1] - small[1]) - 0.25 * M[0],
            "principal point  ",
            plot.BLACK,
            "right",
        ),
        (small[-1], "    image point $(x, y)$", plot.RED, "left"),
        (steps[-1], "  object point $(X, Y, Z)$", plot.BLUE, "left"),
        (centre + 0.74 * (small[1] - centre), " $c$", plot.BLACK, "left"),
        ((small[1] + small[2]) / 2 - (0, 0, 0.3), "$x$", plot.BLACK, "center"),
        ((small[2] + small[3]) / 2 - (0, 0, 0.34), "$y$", plot.BLACK, "center"),
        (0.3 * beside[0] + 0.7 * beside[1], "$W < 0$  ", plot.BLUE, "right"),
        ((steps[1] + steps[2]) / 2 - (0, 0, 0.14), "$U$", plot.BLUE, "center"),
        ((steps[2] + steps[3]) / 2 - (0, 0, 0.08), "  $V$", plot.BLUE, "left"),
    ):
        _write(ax, at, f"{words} " if where == "right" else words, colour, where)
    drawn += [*space.draw_axes(ax, centre, M, 0.9)]
    corner = np.array([-2.0, -0.6, 0.0])
    drawn += [*space.draw_axes(ax, corner, length=0.8, names=("X", "Y", "Z"))]
    fill(ax, np.array([*drawn, *steps]), (0.12, 0.05, 0.6, 0.9))
    plot.show(
        fig,
        "A camera in space and one ray. From the perspective centre the principal"
        " distance c leads along the negative z axis to the principal point of the"
        " image plane; from there x and y lead to the image point. Along the same axis,"
        " from the perspective centre on, W leads, which is negative, then U and V to"
        " the object point. Image point and object point lie"
        " on one straight line through the perspective centre.",
    )


def _write(ax: Axes3D, at: np.ndarray, words: str, colour: str, where: str) -> None:
    look: Look = {"fontsize": TEXT, "color": colour, "zorder": 9}
    ax.text(*np.asarray(at), words, ha=where, va="center", **look)


# --- How does the image move with each unknown? ---


def adjustment_steps(size: np.ndarray, error: np.ndarray) -> None:
    """Show the relative error of a central difference against its step."""
    fig, ax = plt.subplots(figsize=(7, 4.2))
    ax.plot(size, error, "o-", color=plot.BLUE, label="error")
    best = int(np.argmin(error))
    mark: Look = {"color": plot.RED, "markersize": 12, "zorder": 4}
    ax.plot(size[best], error[best], "D", label="smallest", **mark)
    ax.set(xscale="log", yscale="log", xlabel="step (rad)", ylabel="relative error")
    ax.legend(loc="upper center")
    valley = size[error < 1e-8]
    plot.show(
        fig,
        "Relative error of a central difference against its step, both logarithmic: a"
        " valley. From the right it falls with the square of the step; to the left it"
        f" rises again, unevenly. From {valley.min():.0e} to {valley.max():.0e} rad it"
        " is below 1e-08; a diamond marks the smallest.",
    )


# --- What do two photos determine about each other? ---


def epipolar_plane() -> None:
    """Show two rays, the base between their stations, and the plane of all three."""
    fig = plt.figure(figsize=(10, 4.6), layout="none")
    ax = space.space(fig, view=(18, -72))
    point, drawn = np.array([0.25, 0.5, 0.0]), [np.array([(0.25, 0.5, -0.3)])]
    triangle = np.array([*PAIR[:, :3], point])
    pale: Look = {"facecolors": plot.YELLOW, "alpha": 0.45, "zorder": 0}
    plane = Poly3DCollection([triangle], **pale, **space.FREE)
    ax.add_collection3d(plane)
    for exterior, colour, mark, sign in zip(
        PAIR, (plot.BLUE, plot.RED), ("o", "s"), (-1, 1)
    ):
        look: Look = {"color": colour, "axes": False}
        drawn.append(space.draw_camera(ax, exterior, 1.0, **look))
        ray = np.array([exterior[:3], point])
        ax.plot(*ray.T, color=colour, **THICK)
        M = rotation.matrix(*exterior[3:])
        normal = np.cross(*(triangle[:2] - point)) @ M.T  # of the plane, in the camera
        seen = (point - exterior[:3]) @ M.T
        x = np.array([-0.5, 0.5])
        line = np.column_stack([x, (normal[2] - normal[0] * x) / normal[1], [-1, -1]])
        ax.plot(*(exterior[:3] + line @ M).T, color=colour, ls="--", lw=2.5, **FRONT)
        outside, words, where = (
            (0, "epipolar line    ", "right")
            if sign < 0
            else (1, "  epipolar line", "left")
        )
        _write(ax, (exterior[:3] + line @ M)[outside], words, colour, where)
        image = exterior[:3] + seen / -seen[2] @ M
        ax.plot(*image, mark, color=colour, markersize=9, **FRONT)
        name = "left station" if sign < 0 else "right station"
        _write(ax, exterior[:3] + (0, 0, 0.25), name, colour, "center")
        drawn.append(exterior[None, :3] + (0, 0, 0.4))
    ax.plot(*PAIR[:, :3].T, color=plot.BLACK, **THICK)
    ax.plot(*point, "D", color=plot.BLACK, markersize=9, **FRONT)
    for at, words in (
        (PAIR[:, :3].mean(axis=0) + (0, 0, 0.18), "base"),
        (point - (0, 0, 0.2), "object point"),
        (triangle.mean(axis=0) + (0.05, 0, -0.5), "epipolar\nplane"),
    ):
        _write(ax, at, words, plot.BLACK, "center")
    corner = np.array([-1.9, 0.5, 0.0])
    drawn.append(space.draw_axes(ax, corner, length=0.6, names=("X", "Y", "Z")))
    fill(ax, np.concatenate(drawn), (0.03, 0.03, 0.94, 0.94))
    plot.show(
        fig,
        "Two cameras, the base between their perspective centres, and the two rays of"
        " one object point. Base and rays span a triangle, the epipolar plane. It cuts"
        " each photo in a dashed line, the epipolar line, on which the image of the"
        " point lies.",
    )


def to_the_ground() -> None:
    """Show a model in its own frame, and carried to the ground by a similarity."""
    fig = plt.figure(figsize=(10, 4.2), layout="none")
    turn = rotation.matrix(0.25, 0.3, 0.15)
    places = ((0.0, 0.12, 0.36, 0.66), (0.56, 0.08, 0.42, 0.78))
    both = ((0.45 * HOUSE @ turn, ("x", "y", "z")), (HOUSE, ("X", "Y", "Z")))
    for (house, names), where in zip(both, places):
        ax = space.space(fig, view=(20, -60))
        for edge in EDGES:
            ax.plot(*house[list(edge)].T, color=plot.BLUE, linewidth=2.2, clip_on=False)
        look: Look = {"color": plot.RED, "markersize": 10} | FRONT
        ax.plot(*house[list(CONTROL)].T, "^", **look)
        origin = np.array([-1.6, -1.2, 0.0])
        tips = space.draw_axes(ax, origin, length=1.5, names=names)
        ground = np.array([(-1.6, -1.2, 0), (5, -1.2, 0), (5, 4, 0), (-1.6, 4, 0)])
        if names[0] == "X":
            pale: Look = {"facecolors": plot.GREEN, "alpha": 0.15, "zorder": 0}
            flat = Poly3DCollection([ground], **pale, **space.FREE)
            ax.add_collection3d(flat)
            house = np.concatenate([house, ground])
        fill(ax, np.array([*house, origin, *tips, *(1.15 * tips)]), where)
    arrow: Look = {"arrowstyle": "-|>", "lw": 3, "color": plot.BLACK}
    fig.text(0.18, 0.9, "model, in a frame of its own", fontsize=TEXT, ha="center")
    fig.text(0.77, 0.9, "ground", fontsize=TEXT, ha="center")
    plt.figtext(
        0.46, 0.58, "scale $s$, rotation $R$,\nshift $T$", fontsize=TEXT, ha="center"
    )
    fig.add_artist(
        FancyArrowPatch((0.38, 0.5), (0.55, 0.5), mutation_scale=25, **arrow)
    )
    fig.text(0.5, 0.02, "▲ control points", color=plot.RED, fontsize=TEXT, ha="center")
    plot.show(
        fig,
        "Left a small house, rotated, in a frame x, y, z of its own: the model. Right"
        " the same house, larger and upright on the ground in the frame X, Y, Z. An"
        " arrow between them says scale, rotation and shift. Red triangles mark corners"
        " that are known in both frames.",
    )


# --- How far apart should the stations be? ---


def point_clouds() -> None:
    """Show simulated intersections of two rays at four angles, with their ellipses."""
    rng, sigma = np.random.default_rng(4), 0.001
    fig, axes = plt.subplots(2, 2, figsize=(7, 3.7), sharex=True, sharey=True)
    totals = []
    for ax, angle in zip(axes.flat, ANGLES):
        pair = towards(angle)
        perfect = project(NEAR, pair, np.zeros(3))
        image = perfect[:, None] + rng.normal(0, sigma, (2, 400, 2))
        found = orientation.intersect(NEAR, pair, image, sigma=sigma)
        cloud, C = 1000 * found.points[:, [2, 0]], 1e6 * found.covariance.mean(axis=0)
        totals.append(np.sqrt(np.trace(C)))
        for ray in pair[:, [2, 0]]:
            ax.plot(*np.transpose([ray, (0, 0)]), color=plot.GREY, linewidth=1.2)
        ax.plot(*cloud.T, ".", color=plot.SKY, markersize=4)
        plot.error_ellipse(ax, (0, 0), C[np.ix_([2, 0], [2, 0])], 0.95, zorder=3)
        ax.text(-6.6, 1.5, f"{angle}°", fontsize=16, weight="bold")
        ax.text(-6.6, -2.2, f"{totals[-1]:.2f} mm", fontsize=TEXT)
        ax.set(xlim=(-7, 7), ylim=(-2.6, 2.6), aspect="equal")
    for ax in axes[:, 0]:
        ax.set_ylabel("X (mm)")
    for ax in axes[1]:
        ax.set_xlabel("Z, depth (mm)")
    plot.show(
        fig,
        "Clouds of 400 simulated intersections with the 95 % ellipse of their"
        " covariance, for rays that meet at 10, 40, 90 and 150 degrees. At 10 degrees"
        " the cloud is a long needle in depth, at 90 it is round, at 150 it is wide"
        " across. In each stands the root of the sum of the three variances: "
        + ", ".join(f"{total:.2f} mm" for total in totals)
        + ".",
    )


def towards(angle: float) -> np.ndarray:
    """Exteriors (2, 6) of cameras 10 m from the origin, whose rays meet at an angle."""
    a = np.radians([-angle / 2, angle / 2])
    zero = np.zeros(2)
    return np.column_stack([FAR * np.sin(a), zero, FAR * np.cos(a), zero, a, zero])


def base_by_hand() -> None:
    """Show two vertical photos, their rays and the error ellipse, and a slider."""
    import ipywidgets

    def draw(base: int) -> None:
        angle = np.degrees(2 * np.arctan(base / 2 / HEIGHT))
        sx, sz = 1000 * np.array(vertical_precision(base))
        fig, (side, error) = plt.subplots(
            1, 2, figsize=(10, 4.2), width_ratios=(1.25, 1)
        )
        stations = np.array([(-base / 2, HEIGHT), (base / 2, HEIGHT)])
        for station, colour, style in zip(stations, (plot.BLUE, plot.RED), ("-", "--")):
            ray = np.array([station, (0, 0)])
            side.plot(*ray.T, color=colour, linestyle=style)
            side.plot(*station, "s", color=colour)
        side.plot(*stations.T, color=plot.BLACK, linewidth=1.5)
        side.text(0, HEIGHT + 7, f"base {base} m", ha="center", fontsize=TEXT)
        side.set(xlim=(-110, 110), ylim=(-12, 145), aspect="equal")
        side.set(xlabel="X (m)", ylabel="Z (m)", title=f"rays meet at {angle:.0f}°")
        for place, one, ink in (
            (-90, 20, "0.4"),
            (0, base, plot.BLACK),
            (90, 80, "0.4"),
        ):
            deviations = 1000 * np.array(vertical_precision(one))
            covariance = np.diag(deviations**2)
            plot.error_ellipse(error, (place, 0), covariance, 0.95, color=ink)
            low = -3 * deviations[1] - 20
            error.text(place, low, f"{one} m", ha="center", color=ink, fontsize=TEXT)
        error.set(xlim=(-150, 150), ylim=(-320, 240), aspect="equal")
        error.set(xlabel="X (mm)", ylabel="Z (mm)", title="error ellipses, 95 %")
        numbers = f"$\\sigma_X$ = {sx:.0f} mm\n$\\sigma_Z$ = {sz:.0f} mm"
        error.text(12, 140, numbers, fontsize=TEXT)
        plot.show(
            fig,
            f"Left two vertical photos {HEIGHT:.0f} m above a point midway between"
            f" them, base {base} m, rays that meet at {angle:.0f} degrees. Right the"
            f" 95 % ellipse of the point: sigma X {sx:.0f} mm, sigma Z {sz:.0f} mm;"
            " beside it in grey those of 20 m, far longer, and of 80 m, shorter.",
        )

    look: Look = {"min": BASES[0], "max": BASES[1], "step": 20}
    base = ipywidgets.IntSlider(
        40, description="base (m)", continuous_update=False, **look
    )
    interact(draw, base=base)


def vertical_precision(base: float) -> tuple[float, float]:
    """Standard deviations in X and Z (m) of a point midway between vertical photos.

    They are taken from 120 m with c = 35 mm; image coordinates are good to 3 µm.
    """
    zero = np.zeros(2)
    places = np.column_stack([(-base / 2, base / 2), zero, np.full(2, HEIGHT)])
    pair = np.column_stack([places, zero, zero, zero])
    image = project(Camera(C), pair, np.zeros(3))[:, None]
    found = orientation.intersect(Camera(C), pair, image, sigma=SIGMA)
    sx, _, sz = np.sqrt(np.diag(found.covariance[0]))
    return float(sx), float(sz)


def beside_rays(
    points: np.ndarray, exteriors: np.ndarray, photos: np.ndarray, c: float
) -> tuple[int, np.ndarray]:
    """How many points lie before both cameras, and how far apart their rays are (n,).

    The points (n, 3) are the nearest ones to both of their rays.
    """
    before, off = [], []
    for exterior, xy in zip(exteriors, photos):
        rays = np.insert(xy, 2, -c, axis=1) @ rotation.matrix(*exterior[3:])
        rays = rays / np.linalg.norm(rays, axis=1, keepdims=True)
        way = points - exterior[:3]  # from the station to each point
        along = np.sum(way * rays, axis=1, keepdims=True)
        before.append(along[:, 0] > 0)
        off.append(np.linalg.norm(way - along * rays, axis=1))
    return int(np.all(before, axis=0).sum()), np.sum(off, axis=0)
