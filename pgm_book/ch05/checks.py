"""Checks of the exercises of chapter 5, intersection."""

from collections.abc import Callable
from typing import Any

import numpy as np

from pgm_book.common.checks import (
    CheckFailed,
    answer_of,
    call,
    chance,
    compare,
    first_slip,
    near,
    report,
    shaken,
)
from pgm_book.program import camera as collinearity
from pgm_book.program import orientation as lines
from pgm_lab import rotation

PHOTO = np.array([12.0, -8.0, 120.0, 0.2, -0.15, 1.1])
POINTS = np.array([(5.0, 3, 1), (60, 15, 8), (-20, 40, -3), (35, -30, 12)])
GROUND = np.array([(0.0, 0, 0), (90, 0, 5), (0, 80, 9), (85, 70, 0), (40, 30, 2)])
TRUTH = np.array([40.0, 35, 120, 0.05, -0.03, 0.4])
SIDE_BY_SIDE = np.array([1.0, 0.06, -0.08, 0.03, 0.05, -0.04])
CONVERGENT = np.array([1.0, -0.1, 0.15, -0.12, 0.22, 0.17])
START = np.array([46.0, 30, 112, 0, 0, 0.3])
AWAY = (
    "the steps lead away from the photo: adjust needs observed minus computed, anew"
    " in every step, in the order of the rows of A; its x is added to exterior"
)


def project(function: Callable[..., object]) -> None:
    """Check the reader's project(exterior, points, c), which answers (n, 2)."""
    photo, points = shaken(52, PHOTO), shaken(53, POINTS)
    c, other_c = shaken(54, (35.0, 152.9))
    cases = [(photo, points, c), (photo + 0.1, points[:1], other_c)]

    def image(
        M_of: Callable = lambda e: rotation.matrix(*e[3:]),
        origin: Callable = lambda e: e[:3],
        sign: int = -1,
    ) -> Callable:
        def wrong(exterior: np.ndarray, points: np.ndarray, c: float) -> np.ndarray:
            U, V, W = M_of(exterior) @ (points - origin(exterior)).T
            return sign * c * np.column_stack([U, V]) / W[:, None]

        return wrong

    right = image()
    slips = {
        "the sign: W is negative in front of the camera": image(sign=1),
        "M is transposed: it leads from object to image": image(
            lambda e: rotation.matrix(*e[3:]).T
        ),
        "the angles are radians already": image(
            lambda e: rotation.matrix(*np.radians(e[3:]))
        ),
        "M is missing: rotate the ray into the camera frame": image(
            lambda e: np.eye(3)
        ),
        "the perspective centre is not subtracted": image(origin=lambda e: np.zeros(3)),
        "of exterior the first three are the position, the rest angles": image(
            lambda e: rotation.matrix(*e[:3]), lambda e: e[3:]
        ),
        "x and y are exchanged": lambda e, p, c: right(e, p, c)[:, ::-1],
        "y points up in a photo": lambda e, p, c: right(e, p, c) * (1, -1),
        "x points to the right in a photo": lambda e, p, c: right(e, p, c) * (-1, 1),
        "the principal distance is missing": lambda e, p, c: right(e, p, c) / c,
        "divide by W, which differs from point to point": lambda e, p, c: (
            right(e, p, c) * (rotation.matrix(*e[3:]) @ (p - e[:3]).T)[2][:, None]
        ),
    }
    otherwise = "the points are not imaged there"
    holds, hint = compare(function, cases, right, slips, otherwise)
    behind = photo, points + (0, 0, 300), c
    try:
        unsigned = near(call(function, *behind, shape=(4, 2)), -right(*behind))
    except CheckFailed:  # to refuse what is behind the camera is right, too
        unsigned = False
    if holds and unsigned:
        holds, hint = False, "W keeps its sign: it is positive behind the camera"
    report("project", [("one row a point, on its ray", holds, hint)])


def derivatives(function: Callable[..., object]) -> None:
    """Check the reader's derivatives(function, at), which answers (m, u)."""
    at = shaken(55, np.array([0.7, -1.3, 2.1]))
    power = shaken(56, np.array([3.0, -2.0, 0.5, 1.5]))

    def wave(x: np.ndarray) -> np.ndarray:
        x = np.asarray(x, dtype=float)
        return np.sin(x[0] * power) + x[1] ** 3 + x[2] * power

    right = np.column_stack(
        [power * np.cos(at[0] * power), np.full(4, 3 * at[1] ** 2), power]
    )

    def rows(x: np.ndarray) -> np.ndarray:  # as project answers
        return wave(x).reshape(2, 2)

    found = filled(function, wave, at, shape=(4, 3))
    slips = [
        (-right, "the sign: there minus back, divided by the interval between them"),
        (2 * right, "from back to there are two steps"),
        (right / 2, "from back to there are two steps, and each is counted once"),
        (0 * right, "nothing moves: change one element of a copy, then call function"),
        (right[:, [0]] + 0 * right, "every column has its own unknown"),
    ]
    moved_all = right.sum(axis=1, keepdims=True) + 0 * right
    slips.append((moved_all, "move one unknown at a time, from a fresh copy of at"))
    # A second difference of sines and cubes: the right step leaves 1e-8
    error = np.abs(found - right).max() / np.abs(right).max()
    small = np.abs(found).max() / np.abs(right).max()
    if 0 < small < 1e-3 and near(found / small, right, 1e-4):
        hint = "the change is not divided by the interval"
    else:
        hint = next((h for wrong, h in slips if near(found, wrong, 1e-4)), "")
    if not hint and error < 1e-3:
        hint = (
            "nearly: the error is large for a central difference with a good step;"
            " move there and back by the same step of about 1e-6"
        )
    hint = hint or "these are not the changes of the function"
    table = answer_of(function, rows, at)
    flat = np.shape(table) == (4, 3)
    by_columns = flat and near(
        table, right.reshape(2, 2, 3).swapaxes(0, 1).reshape(4, 3), 1e-4
    )
    tiny = [np.array([at[0], small, at[2]]) for small in (0.0, 1e-9)]
    with np.errstate(all="ignore"):
        answers = [np.ravel(answer_of(function, wave, x)) for x in tiny]
    exact = [np.ravel(collinearity.derivatives(wave, x)) for x in tiny]
    integers = answer_of(function, wave, np.array([1, 2, 3]))
    whole = (
        near(
            np.ravel(integers),
            np.ravel(collinearity.derivatives(wave, np.array([1.0, 2, 3]))),
            1e-5,
        )
        if np.shape(integers) == (4, 3)
        else False
    )
    good = bool(error < 2e-7)
    report(
        "derivatives",
        [
            ("a column for each unknown", good, hint),
            (
                "also of a function that returns (n, 2)",
                flat if good else None,
                "where the function returns a table, as project does, make one column"
                " of it with np.ravel",
            ),
            (
                "row by row",
                not by_columns if good and flat else None,
                "one row of the table after the other: np.ravel does so by itself",
            ),
            (
                "where an unknown is zero",
                near(np.array(answers), np.array(exact), 1e-5) if good else None,
                "an unknown may be 0 or tiny, and a part of it is no step: the step is"
                " 1e-6 for every unknown",
            ),
            (
                "whole numbers as well",
                whole if good else None,
                "where at holds whole numbers, a small step is lost: begin with"
                " np.array(at, dtype=float)",
            ),
        ],
    )


def resection(function: Callable[..., object]) -> None:
    """Check the reader's resection(start, image, points, c): exterior and sd."""
    noise = chance(2).normal(0, 0.003, (5, 2))
    ground, c = shaken(57, GROUND, 0.05), shaken(58, 35.0)
    image = collinearity.project(shaken(59, TRUTH, 0.05), ground, c) + noise
    of_example = _names(function) & {"image_mm", "ground_m", 152.916}
    if of_example:
        raise CheckFailed(
            "resection takes its photo, points and c from its arguments image, points"
            f" and c, not from the example: {', '.join(map(str, of_example))}"
        )
    try:
        found = call(function, START, image, ground, c, shape=(2, 6))
    except CheckFailed as failed:
        if hint := _why_stopped(str(failed)):
            raise CheckFailed(f"resection{hint}") from None
        raise
    exterior, sd = lines.resection(START, image, ground, c)
    good = near(found[0], exterior, 1e-6)
    ratio = found[1] / sd
    slips = [
        (START, "exterior is still the start: add the corrections to it"),
        (
            np.append(exterior[:3], np.degrees(exterior[3:])),
            "the angles are wanted in radians",
        ),
        (
            _first_step(image, ground, c),
            "that is one step: put the steps into the loop",
        ),
    ]
    hint = next((h for wrong, h in slips if near(found[0], wrong, 1e-6)), "")
    off, start_off = (np.linalg.norm(e[:3] - exterior[:3]) for e in (found[0], START))
    if not hint and off > start_off:
        hint = AWAY
    elif not hint and off < 1:
        hint = (
            "it comes near, but does not converge: every step needs A and missing anew"
        )
    hint = hint or "the photo does not stand where its points say"
    if near(ratio, ratio[0], 1e-3):
        why = "the square roots of the diagonal of Q are multiplied by sigma0"
    elif near(found[1], sd**2, 1e-3):
        why = "those are variances: the roots are wanted"
    else:
        why = "sd does not follow from sigma0 and the diagonal of Q"
    report(
        "resection",
        [
            ("it converges", good, hint),
            (
                "with its standard deviations",
                near(ratio, 1.0, 1e-3) if good else None,
                why,
            ),
        ],
    )


def _names(function: Callable) -> set:
    """Names and constants that a function and the functions within it use."""
    codes, found = [getattr(function, "__code__", None)], set()
    while codes:
        code = codes.pop()
        found |= {*getattr(code, "co_names", ()), *getattr(code, "co_consts", ())}
        codes += [c for c in getattr(code, "co_consts", ()) if hasattr(c, "co_names")]
    return found


def _why_stopped(said: str) -> str:
    """What follows the name resection in the feedback, if the reason is known."""
    if "NoneType" in said or "at least one array" in said:
        return (
            " got nothing from a function that it uses: do exercises 5.1 and 5.2 first"
        )
    if any(word in said for word in ("llipsis", "A must be", "observed must be")):
        return ": A, missing or sd is still `...`. Your turn!"
    no_function = "not callable", "must be a function", "positional argument"
    if any(words in said for words in no_function):
        return (
            ": derivatives needs a function, which it calls itself: begin with"
            " `lambda e:`, and write e in the place of exterior."
        )
    if any(word in said for word in ("A must have shape", "matmul", "broadcast")):
        return (
            ": A has a row for each photo coordinate, ten here, and missing is an array"
            " of one dimension, of as many numbers: np.ravel makes it of a table."
        )
    lost = "does not lie in front", "depend on one another"  # steps that lead away
    return f": {AWAY}." if any(words in said for words in lost) else ""


def _first_step(image: np.ndarray, ground: np.ndarray, c: float) -> np.ndarray:
    """Where one step from the start leads."""

    def photo(e: np.ndarray) -> np.ndarray:
        return collinearity.project(e, ground, c)

    A = collinearity.derivatives(photo, START)
    misclosure = (image - photo(START)).ravel()
    return START + np.linalg.lstsq(A, misclosure, rcond=None)[0]


# --- Checks of where rays meet: intersection, and the base that a height needs ---


def filled(
    function: Callable[..., object], *arguments: Any, shape: tuple[int, ...]
) -> np.ndarray:
    """As `call`; says in plain words that a loop has not been filled yet."""
    name = getattr(function, "__name__", "your function")
    try:
        return call(function, *arguments, shape=shape)
    except CheckFailed as failed:
        if "at least one array" in str(failed):
            raise CheckFailed(f"{name}: there is no column yet. Your turn!") from None
        if "Singular matrix" in str(failed):
            raise CheckFailed(
                f"{name}: the matrix has no inverse. Is every ray added to it?"
            ) from None
        raise


def intersection(function: Callable) -> None:
    """Check the reader's intersection(stations, directions), which answers (3,)."""
    rng = chance(51)
    point = shaken(60, np.array([12.0, -7.0, 3.0]), 0.5)
    stations = point + rng.normal(0, 1, (4, 3)) * (40, 25, 5) + (0, 0, 100)
    exact = point - stations
    exact /= np.linalg.norm(exact, axis=1, keepdims=True)
    long = np.array([1.0, 30.0, 200.0, 0.2])[:, None]
    skew = exact + rng.normal(0, 0.02, (4, 3))
    skew /= np.linalg.norm(skew, axis=1, keepdims=True)

    found = filled(function, stations, exact, shape=(3,))
    meets = near(found, point, 1e-6)
    slip = "" if meets else _intersection_slips(found, stations, exact)
    two = near(call(function, stations[:2], exact[:2], shape=(3,)), point, 1e-6)
    any_length = near(call(function, stations, exact * long, shape=(3,)), point, 1e-6)
    answer = call(function, stations, skew, shape=(3,))
    stretched = call(function, stations, skew * long, shape=(3,))
    least = near(answer, _nearest(stations, skew), 1e-6)
    report(
        "intersection",
        [
            (
                "rays that meet",
                meets,
                slip or "rays that meet exactly are not given their point",
            ),
            (
                "two rays are enough",
                None if slip else two,
                "two of the rays alone give another point",
            ),
            (
                "any length",
                any_length and near(answer, stretched, 1e-6) if meets else None,
                "the length of a direction changes the point: make it a unit vector",
            ),
            (
                "least squares",
                None if slip else least,
                "for rays that do not meet, the sum of squared distances is not least",
            ),
        ],
    )


def _intersection_slips(found: np.ndarray, stations: np.ndarray, d: np.ndarray) -> str:
    """What is wrong with a point (3,), from stations and unit vectors (n, 3)."""
    along, identity = d[:, :, None] * d[:, None, :], np.eye(3)
    P = identity - along

    def solved(matrices: np.ndarray, right_side: np.ndarray) -> np.ndarray:
        return np.linalg.lstsq(matrices.sum(axis=0), right_side, rcond=None)[0]

    def times(matrices: np.ndarray) -> np.ndarray:
        return np.einsum("nij,nj->i", matrices, stations)

    slips = [
        (
            solved(P, stations.sum(axis=0)),
            "on the right side, too, each station is multiplied by its P",
        ),
        (
            solved(P, -times(P)),
            "the sign of the right side: rearrange the equation once more",
        ),
        (solved(along, times(along)), "that is the part along the ray: P removes it"),
        (
            solved(identity + along, times(identity + along)),
            "P removes the part along the ray: look at the sign",
        ),
        (
            solved(1 - along, times(1 - along)),
            "1 - d d^T has a 1 in every element: the identity is np.eye(3)",
        ),
    ]
    together = identity - along / len(d)  # np.linalg.norm(directions)
    slips.append(
        (
            solved(together, times(together)),
            "divide each direction by its own length, not by that of all together",
        )
    )
    number = identity - np.ones((4, 3, 3))  # d @ d is 1
    slips.append(
        (
            solved(number, times(number)),
            "that is the mean of the stations: d d^T is a 3 x 3 matrix, not a number",
        )
    )
    if hint := first_slip(found, slips, ""):
        return hint
    if np.ptp(found) < 1e-6 * np.abs(found).max():  # d * d leaves (1, 1, 1) open
        return "d d^T has every element of d times every other, d * d only its own"
    way = found - stations[-1]
    if near(P[-1] @ way / np.linalg.norm(way), np.zeros(3), 1e-6):
        return "only the last ray counts: add with += to the matrix and the right side"
    return ""


def relative(function: Callable) -> None:
    """Check the reader's relative(left, right, c): the right photo where X0 is 1."""
    if function is ...:
        raise CheckFailed("relative is not a function yet: write it in your task")
    # X0 is 1 under a secret, too
    side_by_side = np.append(1.0, shaken(61, SIDE_BY_SIDE[1:]))
    convergent = np.append(1.0, shaken(62, CONVERGENT[1:]))
    c, other_c = shaken(63, (35.0, 24.0))
    cases = [_two_photos(side_by_side, c), _two_photos(convergent, other_c)]

    def right_one(left: np.ndarray, right: np.ndarray, c: float) -> np.ndarray:
        return lines.relative(left, right, c)

    def unit_base(*case: Any) -> np.ndarray:
        e = right_one(*case)
        return np.append(e[:3] / np.linalg.norm(e[:3]), e[3:])

    def turned_back(*case: Any) -> np.ndarray:
        e = right_one(*case)
        return np.append(e[:3], rotation.angles(rotation.matrix(*e[3:]).T))

    slips: dict[str, Callable] = {
        "X0 is 1, whatever the length of the base": unit_base,
        "the angles are wanted in radians": lambda *case: np.append(
            right_one(*case)[:3], np.degrees(right_one(*case)[3:])
        ),
        "the left photo is held, not the right one": (
            lambda left, right, c: right_one(right, left, c)
        ),
        "the camera looks along its minus z axis, and so does a ray": (
            lambda left, right, c: right_one(left, right, -c)
        ),
        "M leads from object space to the image, and a ray goes back": turned_back,
    }
    otherwise = (
        "the rays do not lie in one plane with the base: the boxes of all points have a"
        " volume, or the steps are too few"
    )
    left, right, c = cases[0]
    first = call(function, left, right, c, shape=(6,), column=False)
    if near(call(function, left, right, 2 * c, shape=(6,)), first):
        otherwise = "it takes c from elsewhere, and not from its arguments"
    holds, hint = compare(function, cases, right_one, slips, otherwise)

    def counts(row: int) -> bool:
        moved = right.copy()
        moved[row, 1] += 0.1  # mm, across the epipolar line
        return not near(call(function, left, moved, c, shape=(6,)), first, 1e-6)

    report(
        "relative",
        [
            ("base and rays lie in one plane, and X0 is 1", holds, hint),
            (
                "all points count",
                all(map(counts, range(len(right)))) if holds else None,
                "a point can move without any effect, so it is left out: adjust all",
            ),
        ],
    )


def _two_photos(exterior: np.ndarray, c: float) -> tuple[np.ndarray, np.ndarray, float]:
    """What two photos show of twenty points, without error."""
    grid = [(x, y) for x in (-1.0, 0, 1, 2, 3) for y in (-2, -1, 1, 2)]
    points = np.array([(x, y, x * y / 9 - 7) for x, y in grid])
    points[::2, 2] -= 1.3
    photos = np.zeros(6), exterior
    left, right = (collinearity.project(e, points, c) for e in photos)
    return left, right, c


def _nearest(stations: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """By projection of the rays' scales: another method than the solution's."""
    n = len(stations)
    # X - X0_i - t_i d_i = 0 for all i; unknowns X and t
    A = np.hstack([np.tile(np.eye(3), (n, 1)), np.zeros((3 * n, n))])
    for i, d in enumerate(directions):
        A[3 * i : 3 * i + 3, 3 + i] = -d
    return np.linalg.lstsq(A, stations.ravel(), rcond=None)[0][:3]
