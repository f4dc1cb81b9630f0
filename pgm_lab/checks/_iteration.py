"""Feedback on the iteration of least squares matching: when it ends, what it finds."""

from collections.abc import Callable

import numpy as np

from pgm_lab import simulate
from pgm_lab.checks import CheckFailed, answer_of, call, first_slip, near, report
from pgm_lab.lsm import textbook

LAST = "sigma0 and Q are not those of the last adjustment"


def stop(function: Callable) -> None:
    """Check stop(step, half): whether no pixel moves by more than 0.01 px.

    The last two of a step, of h0 and h1, move no pixel; here they are large.
    """

    def answers(half: int, *steps: tuple[float, ...]) -> list[bool]:
        """What the reader's function says to steps of a0, a1, a2, b0, b1, b2."""
        full = [np.array([*step, 0.3, -0.02]) for step in steps]
        return [bool(call(function, step, half, shape=())) for step in full]

    small = (0.004, 1e-4, -2e-4, -0.003, 2e-4, 1e-4)
    log = (-0.0495, 0.01096, -0.12710, 0.0603, -0.02777, -0.03908)
    shear, negative = (0, 0, 0.004, 0, 0, 0), (0, -0.004, 0, 0, 0, -0.003)
    diagonals = (0, 0.002, -0.002, 0, 0, 0), (0, 0, 0, 0, 0.002, 0.002)
    # The corner of a window of 21 pixels moves by 0.0095 px, or by 0.0105 px
    rest = (0, 9.5e-4, 0, 0, 0, 0), (0, 0, 0, 0, 0, -9.5e-4)
    sums = (0.004, 4e-4, 4e-4, 0, 0, 0), (0.004, 6.5e-4, 0, 0, 0, 0)
    hints = [
        ("small steps end it", all(answers(10, small)), "it goes on after small steps"),
        (
            "shifts are looked at",
            not any(answers(10, (0.4, 0, 0, 0, 0, 0), (0, 0, 0, 0.3, 0, 0))),
            "it stops although the window still shifts",
        ),
        (
            "both signs",
            not any(answers(10, (-0.4, 0, 0, -0.2, 0, 0))),
            "it stops at a large negative shift",
        ),
        (
            "shape is looked at",
            not any(answers(10, shear, negative, log)),
            "it stops although the corners of the window still move",
        ),
        (
            "rows as well as columns",
            not any(answers(10, (0, 0, 0, 0, 0.004, 0))),
            "b1 and b2 move the corners, too: it stops although the rows still change",
        ),
        (
            "all four corners",
            not any(answers(10, *diagonals)),
            "there is a corner that it does not look at, and that one still moves",
        ),
        (
            "the parts add up",
            not any(answers(10, *sums)),
            "each part is small, but in one corner of the window they add up to more",
        ),
        (
            "the size of the window counts",
            not any(answers(40, tuple(0.9 * np.array(small)))),
            "the same step moves the corner of a large window by more than 0.01 px",
        ),
        (
            "the window ends at half",
            all(answers(10, *rest)),
            "it goes on although no pixel from −half to half moves by 0.01 px",
        ),
    ]
    # One slip fails many: the first two are enough to read
    report("stop", [p for p in hints if not p[1]][:2] or hints)


def match(function: Callable) -> None:
    """Check match(left, right, point, start, size), which answers trail, sigma0, Q."""
    affine = np.array([2.3, 1.02, 0.05, -1.6, -0.03, 0.99])
    left, right = simulate.texture_pair(
        simulate.texture(seed=1),
        (70, 70),
        affine,
        sigma=0.5,
        seed=3,
        gain=1.1,
        offset=5.0,
    )
    point = (33, 36)
    place = affine.reshape(2, 3) @ (1, *point)
    start = np.array([round(place[0]), 1, 0, round(place[1]), 0, 1, 0, 1.0])
    answer = answer_of(function, left, right, point, start, 21)
    if not isinstance(answer, tuple | list) or len(answer) != 3:
        raise CheckFailed("match must return three things: trail, sigma0, Q")
    trail, sigma0, Q = (np.asarray(part, dtype=float) for part in answer)
    if trail.ndim != 2 or trail.shape[1] != 8 or Q.shape != (8, 8) or sigma0.shape:
        raise CheckFailed(
            "match must return trail of shape (k, 8), the number sigma0 and Q of shape"
            f" (8, 8); got {trail.shape}, {sigma0.shape} and {Q.shape}"
        )
    found = trail[-1]
    off = float(np.hypot(*(found[[0, 3]] - place)))
    away = (
        "the observed values are A less what h0 and h1 B give: the parameters run away"
        if not off < 2
        else "the position is not found"
    )
    if len(trail) > 1 and np.all(np.abs(found[[1, 5]]) < 0.5):
        away = "a step is added to the parameters; it does not replace them"
    elif np.allclose(found[6:], (0, 1)):
        away = "h0 and h1 are left where they began"
    book = textbook.match(left, right, point, start, 21)
    first = book[0][1] - start
    if len(trail) > 1 and near(trail[1, :6] - start[:6], -first[:6], 1e-3):
        away = "the steps go the wrong way: A less what h0 and h1 B give, then added"
    light_found = abs(found[7] - 1 / 1.1) < 0.02 and abs(found[6] + 5 / 1.1) < 2.5
    squared = [(book[1] ** 2, "sigma0 is a standard deviation, not its square")]
    of_Q = "the cofactor matrix is asked for: sigma0 squared stays outside of Q"
    own, wanted = np.diag(Q), np.diag(book[2])
    alike = near(sigma0 / book[1], 1, 0.05)
    said = first_slip(sigma0, squared, LAST, 0.05)
    if alike and near(own / (book[1] ** 2 * wanted), 1, 0.1):
        said = of_Q
    whole = len(trail) > 1 and near(trail[1, :6], book[0][1, :6], 2e-5)
    report(
        "match",
        [
            ("the place, to a hundredth of a pixel", off < 0.01, away),
            (
                "the light",
                light_found or not off < 0.01,
                "the place is right; h0 and h1 are not those of left = h0 + h1 right",
            ),
            (
                "sigma0 and Q",
                (alike and near(own / wanted, 1, 0.1)) or not off < 0.01,
                said,
            ),
            (
                "the trail",
                (near(trail[0], start) and whole) or not (off < 0.01 and light_found),
                "only a part of a step is added to the parameters, or it is rounded"
                if near(trail[0], start)
                else "the first row of the trail is not the start any more: p += step"
                " changes the row that p stands for",
            ),
        ],
    )
