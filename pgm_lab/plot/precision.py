"""Figures of precision: steps of a difference, clouds of points, base and ellipse."""

import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import IntSlider
from numpy.typing import ArrayLike

from pgm_lab import _validate, orientation
from pgm_lab.camera import Camera, project
from pgm_lab.plot import basic
from pgm_lab.plot._sliders import interact
from pgm_lab.plot.basic import Look

HEIGHT, C, SIGMA = 120.0, 35.0, 0.003  # m, mm, mm: of the sliders
FAR, NEAR = 10.0, Camera(35.0)  # m, and the camera: of the clouds
ANGLES = (10, 40, 90, 150)
BASES = (20, 160)  # m
TEXT = 15


def steps(size: ArrayLike, error: ArrayLike) -> None:
    """Show the relative error of a central difference against its step.

    Parameters
    ----------
    size : array_like (n,)
        Steps, positive.
    error : array_like (n,)
        Relative errors, positive.
    """
    size = _validate.finite(size, "size")
    error = _validate.of_shape(error, size.shape, "error")
    if size.ndim != 1 or not size.size or not (np.all(size > 0) and np.all(error > 0)):
        raise ValueError("size and error must be lists of one length, all positive")
    fig, ax = plt.subplots(figsize=(7, 4.2))
    ax.plot(size, error, "o-", color=basic.BLUE, label="error")
    best = int(np.argmin(error))
    mark: basic.Look = {"color": basic.RED, "markersize": 12, "zorder": 4}
    ax.plot(size[best], error[best], "D", label="smallest", **mark)
    ax.set(xscale="log", yscale="log", xlabel="step (rad)", ylabel="relative error")
    ax.legend(loc="upper center")
    valley = size[error < 1e-8] if np.any(error < 1e-8) else size[[best]]
    basic.show(
        fig,
        "Relative error of a central difference against its step, both logarithmic: a"
        " valley. From the right it falls with the square of the step; to the left it"
        f" rises again, unevenly. From {valley.min():.0e} to {valley.max():.0e} rad it"
        " is below 1e-08; a diamond marks the smallest.",
    )


def clouds(seed: int = 4) -> None:
    """Show simulated intersections of two rays at four angles, with their ellipses.

    Parameters
    ----------
    seed : int
        Of the errors of the image points.
    """
    seed = _validate.whole(seed, "seed", 0, 2**32 - 1)
    rng, sigma = np.random.default_rng(seed), 0.001
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
            ax.plot(*np.transpose([ray, (0, 0)]), color=basic.GREY, linewidth=1.2)
        ax.plot(*cloud.T, ".", color=basic.SKY, markersize=4)
        basic.error_ellipse(ax, (0, 0), C[np.ix_([2, 0], [2, 0])], 0.95, zorder=3)
        ax.text(-6.6, 1.5, f"{angle}°", fontsize=16, weight="bold")
        ax.text(-6.6, -2.2, f"{totals[-1]:.2f} mm", fontsize=TEXT)
        ax.set(xlim=(-7, 7), ylim=(-2.6, 2.6), aspect="equal")
    for ax in axes[:, 0]:
        ax.set_ylabel("X (mm)")
    for ax in axes[1]:
        ax.set_xlabel("Z, depth (mm)")
    basic.show(
        fig,
        "Clouds of 400 simulated intersections with the 95 % ellipse of their"
        " covariance, for rays that meet at 10, 40, 90 and 150 degrees. At 10 degrees"
        " the cloud is a long needle in depth, at 90 it is round, at 150 it is wide"
        " across. In each stands the root of the sum of the three variances: "
        + ", ".join(f"{total:.2f} mm" for total in totals)
        + ".",
    )


def towards(angle: float) -> np.ndarray:
    """Exteriors (2, 6) of two cameras 10 m from the origin that look at it.

    Parameters
    ----------
    angle : float
        Between the two rays, in degrees.
    """
    angle = _validate.number(angle, "angle")
    a = np.radians([-angle / 2, angle / 2])
    zero = np.zeros(2)
    return np.column_stack([FAR * np.sin(a), zero, FAR * np.cos(a), zero, a, zero])


def base_by_hand() -> None:
    """Show two vertical photos, their rays and the error ellipse, and a slider."""

    def draw(base: int) -> None:
        angle = np.degrees(2 * np.arctan(base / 2 / HEIGHT))
        sx, sz = 1000 * np.array(vertical(base))
        fig, (side, error) = plt.subplots(
            1, 2, figsize=(10, 4.2), width_ratios=(1.25, 1)
        )
        stations = np.array([(-base / 2, HEIGHT), (base / 2, HEIGHT)])
        for station, colour, style in zip(
            stations, (basic.BLUE, basic.RED), ("-", "--")
        ):
            ray = np.array([station, (0, 0)])
            side.plot(*ray.T, color=colour, linestyle=style)
            side.plot(*station, "s", color=colour)
        side.plot(*stations.T, color=basic.BLACK, linewidth=1.5)
        side.text(0, HEIGHT + 7, f"base {base} m", ha="center", fontsize=TEXT)
        side.set(xlim=(-110, 110), ylim=(-12, 145), aspect="equal")
        side.set(xlabel="X (m)", ylabel="Z (m)", title=f"rays meet at {angle:.0f}°")
        covariance = np.diag([sx**2, sz**2])
        basic.error_ellipse(error, (0, 0), covariance, 0.95, color=basic.BLACK)
        error.set(xlim=(-150, 150), ylim=(-240, 240), aspect="equal")
        error.set(xlabel="X (mm)", ylabel="Z (mm)", title="error ellipse, 95 %")
        numbers = f"$\\sigma_X$ = {sx:.0f} mm\n$\\sigma_Z$ = {sz:.0f} mm"
        error.text(-142, 160, numbers, fontsize=TEXT)
        basic.show(
            fig,
            f"Left two vertical photos {HEIGHT:.0f} m above a point midway between"
            f" them, base {base} m, rays that meet at {angle:.0f} degrees. Right the"
            f" 95 % ellipse of the point: sigma X {sx:.0f} mm, sigma Z {sz:.0f} mm.",
        )

    look: Look = {"min": BASES[0], "max": BASES[1], "step": 20}
    base = IntSlider(40, description="base (m)", continuous_update=False, **look)
    interact(draw, base=base)


def vertical(base: float) -> tuple[float, float]:
    """Standard deviations in X and Z (m) of a point midway between vertical photos.

    Parameters
    ----------
    base : float
        In metres; the photos are taken from 120 m with c = 35 mm, their image
        coordinates are good to 3 µm.
    """
    base = _validate.positive_number(base, "base", "m")
    zero = np.zeros(2)
    places = np.column_stack([(-base / 2, base / 2), zero, np.full(2, HEIGHT)])
    pair = np.column_stack([places, zero, zero, zero])
    image = project(Camera(C), pair, np.zeros(3))[:, None]
    found = orientation.intersect(Camera(C), pair, image, sigma=SIGMA)
    sx, _, sz = np.sqrt(np.diag(found.covariance[0]))
    return float(sx), float(sz)
