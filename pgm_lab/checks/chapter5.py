"""Checks of the exercises of chapter 5, intersection."""

from collections.abc import Callable, Iterable

import numpy as np

from pgm_lab import datasets, rotation
from pgm_lab.checks import CheckFailed, call, first_slip, near, numbers, report

_MISPRINTED = {"b13", "b22", "b23", "b26"}


def misprints(names: Iterable[str]) -> None:
    """Check which coefficients of (M 2.24) the reader found misprinted.

    The names may stand in a list, tuple, set or array of any shape, or in one text
    with commas or spaces between them.
    """
    if isinstance(names, str):
        names = names.replace(",", " ").split()
    elif isinstance(names, np.ndarray):
        names = names.ravel()
    elif not isinstance(names, Iterable):
        names = ()
    try:
        names = [str(name) for name in names]
    except Exception:  # of a stranger's object
        names = []
    names = {name.strip().lower().replace("_", "") for name in names}
    if not names - {""}:
        raise CheckFailed(
            'misprinted is still empty: it must be a list of names such as "b11"'
        )
    known = {f"b{row}{column}" for row in (1, 2) for column in range(1, 7)}
    if names - known:
        raise CheckFailed(
            f"there is no coefficient {', '.join(sorted(names - known))}: write the"
            ' names like "b11"'
        )
    wrong, missed = len(names - _MISPRINTED), len(_MISPRINTED - names)
    report(
        "misprinted",
        [
            (
                "each of them fails",
                not wrong,
                f"{wrong} of your coefficients agree with the moved unknown",
            ),
            (
                "none is missed",
                not missed,
                f"{missed} more deviate: compare both rows, and mind that a relative"
                " deviation of 1e-8 is the finite difference, not a misprint",
            ),
        ],
    )


def right_image(answer: object) -> None:
    """Check the image of (-2.0, -1.2, -1.7) in the right photo of 2010."""
    value = numbers("right_image", answer, (2,), "two numbers, (x, y) in mm")
    left, right = datasets.bani2010_intersection()["exterior"]
    point, c = np.array([-2.0, -1.2, -1.7]), 18.5558

    def projected(exterior: np.ndarray, M: np.ndarray, sign: int = -1) -> np.ndarray:
        U, V, W = M @ (point - exterior[:3])
        return sign * c * np.array([U, V]) / W

    M = rotation.matrix(*right[3:])
    exchanged = np.roll(right, 3)
    slips = [
        (projected(right, M, 1), "the sign: W is negative in front of the camera"),
        (projected(right, M.T), "M is transposed: it turns object into image"),
        (
            projected(right, rotation.matrix(*np.radians(right[3:]))),
            "the angles are radians already",
        ),
        (projected(right, np.eye(3)), "M is missing: turn the ray into the camera"),
        (
            projected(exchanged, rotation.matrix(*exchanged[3:])),
            "angles stand before the position",
        ),
        (projected(left, rotation.matrix(*left[3:])), "that is the left photo"),
        (projected(right, M)[::-1], "x and y are exchanged"),
        (projected(right, M) * (1, -1), "y points up in a photo"),
        (projected(right, M) / c, "the principal distance is missing"),
    ]
    hint = first_slip(value, slips, "the point is not imaged there", 2e-3)
    expected = projected(right, M)
    # Three decimals of a millimetre are enough
    report("right_image", [("the ray", near(value, expected, 1e-3), hint)])


def scale_factors(function: Callable) -> None:
    """Check the reader's scale_factors(base, left, right), which answers (2, n)."""
    base = np.array([30.0, -4.0, 2.0])
    left = np.array([[1.0, 0.7, -5.0], [-0.4, 2.0, -6.0], [2.0, -3.0, -4.0]])
    right = np.array([[-2.0, 1.1, -5.5], [-3.0, 2.5, -5.0], [-1.0, -2.0, -4.5]])
    answer = call(function, base, left, right, shape=(2, 3))
    pairs = np.stack([left, -right], axis=2)[:, :2]
    expected = np.linalg.solve(pairs, np.tile(base[:2, None], (3, 1, 1)))[..., 0].T
    slips = [
        (expected * [[1], [-1]], "the second scale has the wrong sign"),
        (expected[::-1], "the two scales are exchanged"),
        (expected[[0, 0]], "the second scale is that of the left ray"),
    ]
    if near(answer, expected):
        hint = ""
    else:
        other = "at the two scales, left and right do not meet in X and Y"
        hint = first_slip(answer, slips, other, 1e-9)
    meet = base[:2] + answer[1][:, None] * right[:, :2]
    meets = near(answer[0][:, None] * left[:, :2], meet)
    hint = hint or "at the two scales, left and right do not meet in X and Y"
    report("my_scale_factors", [("both rays meet in X and Y", meets, hint)])


def intersection(function: Callable) -> None:
    """Check the reader's intersection(stations, directions), which answers (3,)."""
    rng = np.random.default_rng(51)
    point = np.array([12.0, -7.0, 3.0])
    stations = point + rng.normal(0, 1, (4, 3)) * (40, 25, 5) + (0, 0, 100)
    exact = point - stations
    exact /= np.linalg.norm(exact, axis=1, keepdims=True)
    long = np.array([1.0, 30.0, 200.0, 0.2])[:, None]
    skew = exact + rng.normal(0, 0.02, (4, 3))
    skew /= np.linalg.norm(skew, axis=1, keepdims=True)

    meets = near(call(function, stations, exact, shape=(3,)), point, 1e-6)
    two = near(call(function, stations[:2], exact[:2], shape=(3,)), point, 1e-6)
    any_length = near(call(function, stations, exact * long, shape=(3,)), point, 1e-6)
    answer = call(function, stations, skew, shape=(3,))
    stretched = call(function, stations, skew * long, shape=(3,))
    least = near(answer, _nearest(stations, skew), 1e-6)
    report(
        "my_intersection",
        [
            (
                "rays that meet",
                meets,
                "rays that meet exactly are not given their point",
            ),
            ("two rays are enough", two, "two of the rays alone give another point"),
            (
                "any length",
                not meets or (any_length and near(answer, stretched, 1e-6)),
                "the length of a direction changes the point: make it a unit vector",
            ),
            (
                "least squares",
                least,
                "for rays that do not meet, the sum of squared distances is not least",
            ),
        ],
    )


def base(function: Callable) -> None:
    """Check the reader's base(height_m, c_mm, sigma_um, wanted_m) in metres."""
    cases = np.array([(1000.0, 24.0, 3.0, 0.5), (120.0, 35.0, 1.0, 0.02)])
    answers = np.array([float(call(function, *case, shape=())) for case in cases])
    height, c, sigma, wanted = cases.T
    expected = height**2 / c * np.sqrt(2) * sigma / 1000 / wanted
    ratio = answers / expected
    higher = float(call(function, 2000.0, 24.0, 3.0, 0.5, shape=()))
    report(
        "my_base",
        [
            (
                "twice as high, four times the base",
                near(higher / expected[0], 4.0 * ratio[0]),
                "twice as high, a pixel covers twice the ground, and the rays meet at"
                " half the angle",
            ),
            ("the precision is as wanted", near(ratio, 1.0), _base_slips(ratio)),
        ],
    )


def _base_slips(ratio: np.ndarray) -> str:
    """What is wrong with bases (2,), from their ratio to the right ones."""
    half = "a parallax is the difference of two coordinates: a factor is missing"
    for factor, slips in ((1.0, []), (np.sqrt(2), [half])):
        decade = np.log10(np.clip(np.abs(factor * ratio), 1e-99, 1e99))
        power = np.round(decade[0])
        if abs(power) > 9 or not near(decade, power, 1e-6):
            continue
        if power:
            size = "large" if power > 0 else "small"
            slips.append(f"your base is 10^{abs(power):.0f} times too {size}")
        if np.any(ratio < 0):
            slips.append("a length is positive: look at the sign")
        return ", and ".join(slips)
    return "the base does not follow from the height, the scale and the parallax"


def _nearest(stations: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """By projection of the rays' scales: another way than the solution's."""
    n = len(stations)
    # X - X0_i - t_i d_i = 0 for all i; unknowns X and t
    A = np.hstack([np.tile(np.eye(3), (n, 1)), np.zeros((3 * n, n))])
    for i, d in enumerate(directions):
        A[3 * i : 3 * i + 3, 3 + i] = -d
    return np.linalg.lstsq(A, stations.ravel(), rcond=None)[0][:3]
