"""Checks of the exercises of chapter 9, from a board and two photos to a surface."""

from collections.abc import Callable
from typing import Any

import numpy as np

from pgm_book.common.checks import (
    answer_of,
    call,
    chance,
    compare,
    near,
    report,
    shaken,
    varied,
)
from pgm_book.common.own_program import CheckFailed
from pgm_book.program import surface as textbook
from pgm_book.program.bundle import without_lens
from pgm_book.program.camera import project
from pgm_book.program.orientation import resection
from pgm_lab import datasets, rotation
from pgm_lab._validate import real

CAMERA = np.array([0.53, 0.006, -0.004, -0.8, 1.0, 0.0, 0.002, -0.001, 3e-4, -2e-4])
RIGHT = np.array([1.0, 0.08, -0.12, 0.04, -0.06, 0.09])


# --- The board ---


def _photos() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Image points (5, 30, 2) of a flat board with noise, starts, and the board."""
    X, Y = np.meshgrid(np.arange(6.0), -np.arange(5.0))
    board = np.column_stack([X.ravel(), Y.ravel(), np.zeros(30)])
    camera, rng = _camera(), chance(9)
    fixed = np.array(
        [
            (2.5, -2, 8, 0, 0, 0),
            (-3, -2, 6, 0, -0.7, 0.1),
            (8, -2, 6, 0, 0.7, 1.6),
            (2, 4, 6, -0.7, 0, 0.2),
            (2, -8, 6, 0.7, 0, -0.1),
        ]
    )
    exteriors = shaken(91, fixed, 0.03)
    xy = np.array([_seen(project(e, board, camera[0]), camera) for e in exteriors])
    xy += 0.0002 * rng.standard_normal(xy.shape)
    starts = exteriors + 0.02 * rng.standard_normal(exteriors.shape)
    return xy, np.array([0.55, *np.zeros(9)]), starts, board


def _camera() -> np.ndarray:
    """The camera, or under a secret another one."""
    return shaken(92, CAMERA, 0.05)


def _right() -> np.ndarray:
    """The right photo, or under a secret another one; its X0 is 1."""
    return np.append(1.0, shaken(93, RIGHT[1:]))


def _seen(ideal: np.ndarray, camera: np.ndarray) -> np.ndarray:
    """Image points as the lens of a camera shows them."""
    xy = ideal + camera[1:3]
    for _ in range(30):
        xy = xy + ideal - without_lens(xy, camera)
    return xy


def flat_board(function: Callable) -> None:
    """Check the adjustment of a camera with the board as it was printed."""
    case = _photos()
    camera, C, sigma0 = textbook.flat_board(*case)
    try:
        answer = answer_of(function, *case, first="lessons 5 and 6")
    except CheckFailed as failed:
        if not isinstance(failed.__cause__, ValueError | TypeError):
            raise
        raise CheckFailed(
            "flat_board: v[i] is still open, or not that of photo i: `project` takes"
            " its station, the grid and c, one number; `without_lens` its points and"
            " the whole camera"
        ) from None
    try:
        found, covariance, sigma = (real(part, "the answer") for part in answer)
    except Exception:  # whatever a stranger's object raises
        raise CheckFailed(
            "flat_board must return the camera (10,), its covariance (10, 10) and"
            " sigma0"
        ) from None
    shapes = found.shape, covariance.shape, sigma.shape
    if shapes != ((10,), (10, 10), ()):
        raise CheckFailed(
            "flat_board must return the camera (10,), its covariance (10, 10) and"
            f" sigma0; got shapes {shapes[0]}, {shapes[1]}, {shapes[2]}"
        )
    if sigma == 0:
        raise CheckFailed("flat_board adjusts nothing yet. Your turn!")
    sd = np.sqrt(np.diag(C))
    off = np.nan_to_num(np.abs(found - camera) / sd, nan=1e9)
    if np.allclose(found, case[1]):
        hint = "the unknowns stay at their start: add the step to them"
    elif np.all(np.abs(found[3:]) < 1e-9):
        hint = "the distortion stays 0: correct the measured points for the lens"
    elif off.max() > 1e3:
        hint = (
            "the steps lead away: the misclosure is computed minus observed, and the"
            " step has to make it smaller"
        )
    else:
        hint = "the steps end elsewhere: look at what is computed and what observed"
    ratio = np.sqrt(np.abs(np.diag(covariance)) / np.diag(C))
    right = bool(off.max() < 0.05)
    report(
        "flat_board",
        [
            ("the camera", right, hint),
            (
                "sigma0",
                near(sigma / sigma0, 1, 0.01) if right else None,
                "sigma0 is not that of the last adjustment",
            ),
            (
                "the covariance",
                near(ratio, np.ones(10), 0.01) if right else None,
                "the covariance is sigma0 squared times Q",
            ),
        ],
    )


def new_photo(function: Callable) -> None:
    """Check what a camera and a board leave in a photo that took no part."""
    xy, _, starts, board = _photos()
    bent = board + np.column_stack([0 * board[:, :2], 0.02 * (board[:, 0] - 2.5) ** 2])
    lens = _camera()
    cases = [(xy[0], lens, board, starts[0]), (xy[1], lens, bent, starts[1])]

    def left(*case: Any) -> np.ndarray:
        xy, camera, board, start = case
        ideal = without_lens(xy, camera)
        exterior, _ = resection(start, ideal, board, camera[0])
        return project(exterior, board, camera[0]) - ideal

    slips = {
        "that is the root mean square of distances: take it of all x and y": (
            lambda *case: np.sqrt(2) * textbook.new_photo(*case)
        ),
        "that is in pixels: mm are wanted": (
            lambda *case: 1000 * textbook.new_photo(*case)
        ),
        "that is the mean square: its root is wanted": (
            lambda *case: textbook.new_photo(*case) ** 2
        ),
        "those are differences with their signs, which cancel": (
            lambda *case: float(np.mean(left(*case)))
        ),
        "that is the mean of absolute values, not a root mean square": (
            lambda *case: float(np.mean(np.abs(left(*case))))
        ),
        "take the mean of all values, without a redundancy": (
            lambda *case: float(
                np.sqrt(np.sum(left(*case) ** 2) / (2 * len(case[0]) - 6))
            )
        ),
        "compare with the corrected image points": (
            lambda *case: float(
                np.sqrt(np.mean((left(*case) + without_lens(*case[:2]) - case[0]) ** 2))
            )
        ),
    }
    # In units in which `near`, which compares with 1 at least, can tell them apart
    scaled = _in_pixels(function)
    holds, hint = compare(
        scaled,
        cases,
        _in_pixels(textbook.new_photo),
        {words: _in_pixels(wrong) for words, wrong in slips.items()},
        "it is not the root mean square of what the resection leaves",
    )
    report("new_photo", [("the root mean square of what is left", holds, hint)])


def _in_pixels(function: Callable) -> Callable:
    """The same function with results in units of 0.0001 mm, under its own name."""
    if not callable(function):
        return function

    def scaled(*case: Any) -> Any:
        answer = function(*case)
        return answer if answer is None or answer is ... else 1e4 * np.asarray(answer)

    scaled.__name__ = getattr(function, "__name__", "your function")
    return scaled


# --- The pair ---


def _two(
    exterior: np.ndarray, c: float, size: float = 0.02
) -> tuple[np.ndarray, np.ndarray]:
    """Image points of nine points, with errors (mm) that leave y parallaxes."""
    points = np.array([(x, y, x * y / 9 - 7) for x in (-1.0, 1, 3) for y in (-2, 0, 2)])
    points[::2, 2] -= 1.3
    noise = size * chance(4).standard_normal((2, 9, 2))
    left = project(np.zeros(6), points, c) + noise[0]
    return left, project(exterior, points, c) + noise[1]


def y_parallaxes(function: Callable) -> None:
    """Check the y parallaxes in the normal case."""
    right, (c, other_c) = _right(), shaken(94, (24.0, 35.0))
    half = right * 0.5 + (0.5, 0, 0, 0, 0, 0)
    # Errors of the other sign in the second case, and so parallaxes of both signs
    cases = [(right, *_two(right, c), c), (half, *_two(half, other_c, -0.02), other_c)]
    right_one = textbook.y_parallaxes

    def wrong(turns: Callable, axis: int = 1) -> Callable:
        """The same with other rotations of left and right rays, or along the base."""

        def of(e: Any, left: Any, right: Any, c: Any) -> Any:
            R, S = turns(*textbook.frame(e))
            first = np.insert(left, 2, -c, 1) @ R.T
            second = np.insert(right, 2, -c, 1) @ S.T
            return -c * (first[:, axis] / first[:, 2] - second[:, axis] / second[:, 2])

        return of

    def unscaled(e: Any, left: Any, right: Any, c: Any) -> Any:
        M, N = textbook.frame(e)
        rays = np.insert(left, 2, -c, 1), np.insert(right, 2, -c, 1) @ M
        return (rays[0] @ N.T - rays[1] @ N.T)[:, 1]

    slips: dict[str, Callable] = {
        "the sign: left minus right, and the photo lies at minus c": (
            lambda *case: -right_one(*case)
        ),
        "a parallax has a sign: return y' minus y'' as it is": (
            lambda *case: np.abs(right_one(*case))
        ),
        "those are x parallaxes": wrong(lambda M, N: (N, N @ M.T), axis=0),
        "a ray of the right photo goes back into object space by the transpose of M": (
            wrong(lambda M, N: (N, N @ M))
        ),
        "the right ray is still in the frame of its photo: M is missing": (
            wrong(lambda M, N: (N, N))
        ),
        "the right ray is not yet in the normal case: N is missing": (
            wrong(lambda M, N: (N, M.T))
        ),
        "N rotates object space into the normal case; here it is its transpose": (
            wrong(lambda M, N: (N, N.T @ M.T))
        ),
        "first M goes back into object space, then N into the normal case": (
            wrong(lambda M, N: (N, M.T @ N))
        ),
        "a ray of the photo is (x, y, -c)": lambda e, left, right, c: right_one(
            e, left, -right, c
        ),
        "rays are not yet image points: where do they meet the plane z = -c?": unscaled,
        "c is missing: parallaxes are wanted in mm": (
            lambda *case: right_one(*case) / case[3]
        ),
    }
    call(function, *cases[0], shape=(len(cases[0][1]),), column=False)
    holds, hint = compare(
        function, cases, right_one, slips, "it is not y' minus y'' in the normal case"
    )
    report("y_parallaxes", [("y' minus y'' in the normal case", holds, hint)])


def base_length(function: Callable) -> None:
    """Check the length of the base from a distance."""
    e, (c, other_c, one, other) = _right(), shaken(95, (24.0, 35.0, 1.7, 0.4))
    cases = [
        (e, *(p[[0, 7]] for p in _two(e, c)), c, one),
        (e, *(p[[2, 3]] for p in _two(e, other_c)), other_c, other),
    ]
    right = textbook.base_length

    def unit(*case: Any) -> float:
        return float(right(*case) / np.linalg.norm(case[0][:3]))

    slips: dict[str, Callable] = {
        "that is the X of the base, its unit; its length is wanted": unit,
        "that is upside down: a larger distance in the scene, a longer base": (
            lambda *case: np.linalg.norm(case[0][:3]) ** 2 / right(*case)
        ),
        "that is the length in units of its X: how many metres is a unit?": (
            lambda *case: np.linalg.norm(case[0][:3])
        ),
        "that is the distance in the model, not the base": (
            lambda *case: np.linalg.norm(case[0][:3]) / right(*case) * case[4]
        ),
        "the distance takes no part: where it is twice as long, the base is as well": (
            lambda *case: right(*case) / case[4]
        ),
        "the right ray is still in the frame of its photo: M is missing": (
            lambda e, *rest: right(np.append(e[:3], np.zeros(3)), *rest)
        ),
        "the right ray goes back into object space: M leads to the image": (
            lambda e, *rest: right(
                np.append(e[:3], rotation.angles(rotation.matrix(*e[3:]).T)), *rest
            )
        ),
    }
    otherwise = "it is not the base that makes the distance as long as it is"
    holds, hint = compare(function, cases, right, slips, otherwise)
    report("base_length", [("in metres, by the distance", holds, hint)])


def surface_point(function: Callable) -> None:
    """Check one point of the surface, and where there is none."""
    pair = _motorcycles()
    base, c, pixel, sigma = shaken(98, (0.193, 0.995, 0.001, 0.2))
    rest: tuple = ((20, 70), base, c, pixel, sigma)
    places = [(100, 60), (140, 45), (170, 30)]
    answers = [call(function, pair, *p, *rest, shape=(4,), nan=True) for p in places]
    found = np.array(answers)
    wanted = np.array([textbook.surface_point(pair, *p, *rest) for p in places])
    depth = -wanted[:, 2:3]
    slips = [
        (wanted * (1, 1, -1, 1), "the sign of Z: the camera looks along -z"),
        (wanted * (1, -1, 1, 1), "y points up, and rows count downwards"),
        (wanted / (1, 1, 1, sigma), "the standard deviation is that of a whole pixel"),
        (
            wanted * (*3 * [pixel], 1),
            "a parallax is the disparity times the pixel size",
        ),
        (
            np.column_stack([wanted[:, :3], wanted[:, 3:] / (depth / base)]),
            "the standard deviation is that across the ray: H/B is missing",
        ),
        (
            np.column_stack([wanted[:, :3], wanted[:, 3:] / (depth / base) ** 2]),
            "`sigma_height` takes H first, then B",
        ),
    ]
    hint = next(
        (words for wrong, words in slips if near(found, wrong, 1e-6)),
        "the point is not that of your `best_disparity` and `model_point`, with x and y"
        " in mm, or its sd not that of your `sigma_height`, with H above zero, the"
        " given gsd, and sigma in px",
    )
    if not np.isfinite(found).all():
        hint = THERE
    right = near(found, wanted, 1e-6)
    gap = _gap(function, pair, rest) if right else (None, "")
    report(
        "surface_point",
        [
            ("X, Y, Z and the sd of Z", right, hint),
            ("nothing where r is below 0.8", *gap),
        ],
    )


def _motorcycles() -> tuple[np.ndarray, np.ndarray]:
    """A part of a pair of photos, under a secret with noise of half a grey value."""
    scene = datasets.motorcycle()
    pair = scene.left[150:250, 250:450], scene.right[150:250, 250:450]

    def noisy(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        left, right = (photo + rng.normal(0, 0.5, photo.shape) for photo in pair)
        return left, right

    return varied(96, pair, noisy)


GAP = "where r is below 0.8, or NaN, return four NaN"
THERE = "where r is 0.8 or above there is a point: which way is r compared?"


def _gap(function: Callable, pair: tuple, rest: tuple) -> tuple[bool, str]:
    """Whether it returns NaN where the windows do not match well, and only there."""
    noise = chance(5).uniform(0, 255, pair[0].shape)
    for right, place, kept in (
        (noise, (110, 40), False),
        (pair[1], (140, 33), False),  # r is 0.75
        (pair[1], (105, 45), True),  # 0.84
    ):
        point = call(function, (pair[0], right), *place, *rest, shape=(4,), nan=True)
        if not np.all(np.isfinite(point) == kept):
            return False, THERE if kept else GAP
    return True, ""
