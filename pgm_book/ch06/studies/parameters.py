"""Which interior parameters the real network of Muliawan 2013 needs, and which lens.

``python -m pgm_book.ch06.studies.parameters`` writes results/parameters.csv and
results/lens.csv; tests/ch06/test_studies.py repeats it.

Parameters that are not estimated keep their start values, as a user would leave them:
c = 35 mm, all others 0.
"""

from dataclasses import replace

import numpy as np

from pgm_book.ch06.studies import starts
from pgm_book.common import study
from pgm_lab import bundle, camera
from pgm_lab.camera import PARAMETERS, Camera

COLUMNS = (
    *("selection", "estimated", "changed", "t", "effect_um", "sigma0"),
    *("c_mm", "sd_c_mm", "sd_points_mm", "points_moved_mm"),
)
LENS_COLUMNS = ("quantity", "unit", "backward", "forward", "difference")


def forward(net: bundle.Network, steps: int = len(PARAMETERS)) -> list[tuple]:
    """Take in, one after the other, the parameter that lowers sigma0 most."""
    whole, chosen, rows = bundle.adjust(net), [], []
    for _ in range(steps):
        tried = {
            name: bundle.adjust(net, (*chosen, name))
            for name in PARAMETERS
            if name not in chosen
        }
        best = min(tried, key=lambda name: tried[name].sigma0)
        chosen.append(best)
        rows.append(row("forward", "+" + best, best, tried[best], tried[best], whole))
    return rows


def backward(net: bundle.Network) -> list[tuple]:
    """Leave out, one after the other, the parameter with the smallest t; c stays."""
    whole = found = bundle.adjust(net)
    rows = [row("backward", "all ten", "c", found, found, whole)]
    while len(found.estimate) > 1:
        tests = bundle.significance(found)
        worst = min(tests, key=lambda test: abs(test.t)).name
        kept = [name for name in found.estimate if name != worst]
        before, found = found, bundle.adjust(net, kept)
        rows.append(row("backward", "-" + worst, worst, before, found, whole))
    return rows


def row(selection, changed, name, tested, found, whole) -> tuple:
    """One row: t and effect of the parameter from `tested`, all else from `found`."""
    t, effect = "", ""
    for test in bundle.significance(tested):
        if test.name == name:
            t, effect = f"{test.t:.1f}", f"{1000 * test.effect:.2f}"
    c = found.cameras[0].c
    sd_c = found.sd_interior[0] if "c" in found.estimate else 0.0
    return (
        *(selection, " ".join(found.estimate), changed, t, effect),
        *(f"{found.sigma0:.4f}", f"{c:.4f}", f"{sd_c:.4f}"),
        f"{rms(found.sd_points):.4f}",
        f"{rms(found.points - whole.points):.4f}",
    )


def rms(values: np.ndarray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def lenses(net: bundle.Network) -> list[tuple]:
    """The same observations with both lens directions.

    Of the correction of an image point, the mean over a circle about the principal
    point, and the rays scaled to the same principal distance: what c takes over from
    the lens, or x0 and y0 from the angles, is no difference of the lens.
    """
    ours = bundle.adjust(net)
    other = replace(net, cameras=Camera(net.cameras[0].c, lens="forward"))
    theirs = bundle.adjust(other)
    a, b = ours.cameras[0], theirs.cameras[0]
    rows = [compared("sigma0", "1", ours.sigma0, theirs.sigma0)]
    rows += [
        compared(name, "mm" if i < 3 else "powers of mm", *values)
        for i, (name, *values) in enumerate(
            zip(PARAMETERS, a.interior, b.interior, strict=True)
        )
    ]
    for radius in (2, 4, 6, 8, 10):
        values = correction(a, radius, a.c), correction(b, radius, a.c)
        rows.append(compared(f"correction at {radius} mm", "um", *values))
    largest = {
        ("residuals", "um"): 1000 * (theirs.residuals - ours.residuals),
        ("points", "mm"): theirs.points - ours.points,
        ("points over their sd", "1"): (theirs.points - ours.points) / ours.sd_points,
    }
    for (name, unit), off in largest.items():
        rows.append((f"largest of {name}", unit, "", "", f"{np.abs(off).max():.2g}"))
    return rows


def correction(cam: Camera, radius: float, c: float) -> float:
    """Mean correction of image points on a circle, in micrometres, for a given c."""
    turn = np.linspace(0, 2 * np.pi, 37)[:-1]
    circle = radius * np.transpose([np.cos(turn), np.sin(turn)])
    ideal = camera.ideal(cam, circle + cam.interior[1:3]) * c / cam.c
    return 1000 * float(np.mean(np.linalg.norm(ideal, axis=1)) - radius)


def compared(name: str, unit: str, ours: float, theirs: float) -> tuple:
    """Row of the second table."""
    return name, unit, f"{ours:.6g}", f"{theirs:.6g}", f"{theirs - ours:.2g}"


if __name__ == "__main__":
    net = starts.network()
    study.write("ch06", "parameters", COLUMNS, forward(net) + backward(net))
    study.write("ch06", "lens", LENS_COLUMNS, lenses(net))
