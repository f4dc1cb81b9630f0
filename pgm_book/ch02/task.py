"""The task of chapter 2: thirty points of a photo, to be found in another one.

Both photos are cut from the real orthophoto. The ground is not flat, the crowns of high
trees stand over it, and one small tree was planted many times, in rows.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from scipy import ndimage

from pgm_book.common.checks import CheckFailed
from pgm_book.task import Part, grey, table
from pgm_lab import datasets, plot
from pgm_lab.plot.basic import Look

ROWS, COLUMNS = 320, 460
BLUR = 0.5  # px, of the lens
NOISE = 2.0  # grey values, of a photo
SEEN, PLANTED, CROWN, HIDDEN = range(4)  # kinds of points
HOW_MANY = 12, 8, 4, 6
RADIUS, STEP, TREES = 24, 9, 9  # px: of a high crown, and between the small trees
ALLOWED = 13  # points of thirty, wrong ones counted twice
FORM = "30 rows of (column, row) in the right photo, NaN where a point has no match"

EVERY = (
    "Nearly every point has a pixel. A search always finds a highest r, also where the"
    " point is hidden: how high is it, and does the search back from there end where it"
    " began?"
)
REPEATED = (
    "Look at the points among the rows of small trees: how high is the second summit of"
    " their maps of r?"
)
STRICT = (
    "Points that both photos show are missing. Does the search window hold all four"
    " matches of known.csv? How high is r at points that you see in both photos?"
)
SWAPPED = "Column and row are exchanged: column first."
SHIFT = "Those are shifts; the pixel in the right photo is wanted."
BESIDE = (
    "All pixels are off by the same amount. Is the pixel the centre of the template,"
    " and where does the map of r begin?"
)
OTHERWISE = (
    "Some pixels are wrong: draw the map of r for a point that you trust, and for one"
    " that you do not. A large template reaches over the edge of a crown."
)


@dataclass(frozen=True)
class Truth:
    """Two photos, thirty points of the left one, and where the right one has them."""

    left: np.ndarray
    right: np.ndarray
    points: np.ndarray  # (30, 2): column, row
    there: np.ndarray  # (30, 2), of hidden ones, too
    kind: np.ndarray  # (30,): SEEN, PLANTED, CROWN or HIDDEN


def make(chance: np.random.RandomState) -> tuple[dict[str, str | np.ndarray], Truth]:
    """Two photos, thirty points, and four more that were measured in both."""
    ground, tree = _cut(chance, 580, 440), _cut(chance, STEP, STEP)
    middle = np.array([chance.randint(160, 361), 160])  # of the rows of small trees
    mask = _disc(STEP, STEP / 2 - 1)
    tree = 40 + 80 * mask * (tree - tree.min()) / np.ptp(tree) + 100 * (1 - mask)
    rows = np.tile(tree, (TREES, TREES))
    (c, r), half = middle + 60, len(rows) // 2
    ground[r - half : r - half + len(rows), c - half : c - half + len(rows)] = rows

    shift = np.array([chance.randint(-38, -9), chance.randint(-9, 10)])
    phase, length = chance.uniform(0, 2 * np.pi, 2), chance.uniform(330, 400, 2)

    def moved(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """By how many columns the relief moves the ground."""
        across = np.sin(2 * np.pi * x / length[0] + phase[0])
        return 4 * across + 3 * np.sin(2 * np.pi * y / length[1] + phase[1])

    row, column = np.indices((ROWS, COLUMNS)).astype(float)
    x, y = column - shift[0], row - shift[1]
    for _ in range(20):  # the ground that the right photo shows
        x = column - shift[0] - moved(x, y)
    photos = [ndimage.map_coordinates(ground, [y + 60, x + 60], order=3) for x, y in
              ((column, row), (x, y))]  # fmt: skip

    crowns = _crowns(middle, chance)
    high = np.zeros((3, 2), int)
    high[:, 0] = np.rint(moved(*crowns.T)).astype(int) - chance.randint(22, 28, 3)
    for centre, by in zip(crowns, high + shift):
        top, mask = _cut(chance, 50, 50), _disc(50, RADIUS)
        for photo, (c, r) in zip(photos, (centre, centre + by)):
            part = photo[r - 25 : r + 25, c - 25 : c + 25]
            part += (top - top.mean() + part.mean() - part) * mask
    light = chance.uniform(35, 60) + chance.uniform(0.5, 0.7) * photos[1]
    photos[1] = light * (1.1 - 0.2 * column / COLUMNS)
    left, right = (grey(g + NOISE * chance.standard_normal(g.shape)) for g in photos)
    points, there, kind = _points(left, middle, crowns, high, moved, chance)
    there = there + shift
    known = np.rint(np.column_stack([points, there])[-4:]).astype(int)
    order = chance.permutation(30)
    points, there, kind = points[order], there[order], kind[order]
    known_head = "left_column,left_row,right_column,right_row"
    return {
        "left.png": left,
        "right.png": right,
        "points.csv": table("column,row", "{},{}", points),
        "known.csv": table(known_head, "{},{},{},{}", known),
    }, Truth(left, right, points, there, kind)


def judge(truth: Truth, result: object) -> list[Part]:
    """Return how many points are missing, the wrong ones counted twice."""
    found = _pixels(result)
    given, right = _given(found), _right(truth, found)
    missing = np.sum(~given & (truth.kind != HIDDEN))
    lost = float(missing + 2 * np.sum(given & ~right))
    words = f"{missing} missing and {np.sum(given & ~right)} wrong, counted twice"
    return [Part(words, lost, ALLOWED, "points")]


def slips(truth: Truth) -> dict[str, np.ndarray]:
    """Return what the likeliest wrong programs give."""
    best = np.rint(truth.there)
    best[truth.kind == HIDDEN] = np.nan
    guessed, strict, all_given = best.copy(), best.copy(), np.rint(truth.there)
    for wrong in (guessed, all_given):
        wrong[truth.kind == PLANTED, 0] += STEP
    strict[truth.kind != CROWN] = np.nan
    return {
        EVERY: all_given,
        REPEATED: guessed,
        STRICT: strict,
        SWAPPED: best[:, ::-1],
        SHIFT: best - truth.points,
        BESIDE: best - 10,
    }


def hint(truth: Truth, result: object) -> str:
    """Return the hint to what most points suffer from."""
    found = _pixels(result)
    given, hidden = _given(found), truth.kind == HIDDEN
    wrong, seen = given & ~_right(truth, found), given & ~hidden
    if np.sum(wrong & seen) > np.sum(seen) / 2:
        by = np.median((found - truth.there)[seen], axis=0)
        others = {
            SWAPPED: found[:, ::-1],
            SHIFT: found + truth.points,
            BESIDE: found - by,
        }
        for words, other in others.items():
            if np.sum(_right(truth, other) & seen) > np.sum(seen) / 2:
                return words
    if np.sum(wrong & hidden) >= 2:
        return EVERY
    if np.sum(wrong & (truth.kind == PLANTED)) >= 2:
        return REPEATED
    shown = (truth.kind == SEEN) | (truth.kind == CROWN)
    return STRICT if np.sum(~given & shown) > 2 * np.sum(wrong) else OTHERWISE


def picture(truth: Truth, result: object) -> tuple[Figure, str]:
    """Draw all points in both photos: right, wrong, missing, rightly left out."""
    found = _pixels(result)
    given, right, hidden = _given(found), _right(truth, found), truth.kind == HIDDEN
    groups = (
        ("right", right, "o", plot.SKY),
        ("wrong", given & ~right, "X", plot.RED),
        ("missing", ~given & ~hidden, "s", plot.ORANGE),
        ("hidden, left out", ~given & hidden, "D", plot.GREEN),
    )
    fig, axes = plt.subplots(1, 2, figsize=(10, 4.4))
    photos = {"left": truth.left, "right, at the true places": truth.right}
    for ax, (name, photo), at in zip(axes, photos.items(), (truth.points, truth.there)):
        ax.imshow(photo // 24, interpolation="nearest")  # a small file
        for label, chosen, mark, colour in groups:
            look: Look = {"color": colour, "ls": "none", "ms": 9, "mec": "black"}
            ax.plot(*at[chosen].T, mark, label=f"{np.sum(chosen)} {label}", **look)
        ax.set_title(name)
        ax.set_axis_off()
    handles, labels = axes[0].get_legend_handles_labels()
    fig.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=14)
    counts = ", ".join(f"{np.sum(chosen)} {label}" for label, chosen, *_ in groups)
    return fig, (
        f"Both photos with the thirty points: {counts}. In the middle stand rows of"
        " small trees that look alike; hidden points lie to the left of high crowns."
    )


# --- What an answer holds ---


def _pixels(result: Any) -> np.ndarray:
    """Return an answer as (30, 2); None or one NaN is a missing pixel."""
    try:
        rows = [
            2 * (np.nan,) if one is None or one is np.nan else one for one in result
        ]
        found = np.array(rows, dtype=float)
    except (TypeError, ValueError):
        raise CheckFailed(f"the result must be {FORM}") from None
    if found.shape != (30, 2):
        raise CheckFailed(f"the result must be {FORM}; got {found.shape}")
    return found


def _given(found: np.ndarray) -> np.ndarray:
    return np.all(np.isfinite(found), axis=1)


def _right(truth: Truth, found: np.ndarray) -> np.ndarray:
    """Whether a point has a match, and a pixel at most 1 px from it, in x and in y."""
    off = np.abs(found - truth.there).max(axis=1)
    return (off <= 1) & (truth.kind != HIDDEN)


# --- How the photos are made ---


def _cut(chance: np.random.RandomState, columns: int, rows: int) -> np.ndarray:
    """Return a part of the orthophoto, 2 × 2 pixels made one."""
    grey = datasets.yellowstone().grey.astype(float)
    c, r = chance.randint(1536 - 2 * columns), chance.randint(1536 - 2 * rows)
    part = grey[r : r + 2 * rows, c : c + 2 * columns]
    made_one = part.reshape(rows, 2, columns, 2).mean(axis=(1, 3))
    return ndimage.gaussian_filter(made_one, BLUR)


def _disc(size: int, radius: float) -> np.ndarray:
    """Return 1 inside a circle, 0 outside, and what lies between on a rim of 2 px."""
    d = np.arange(size) - (size - 1) / 2
    return np.clip((radius + 1 - np.hypot(*np.meshgrid(d, d))) / 2, 0, 1)


def _crowns(middle: np.ndarray, chance: np.random.RandomState) -> np.ndarray:
    """Choose where three high crowns stand, apart from each other and from the rows."""
    while True:
        found = chance.randint((125, 75), (401, 246), (3, 2))
        apart = [np.hypot(*(a - b)) for a, b in zip(found, found[[1, 2, 0]])]
        if min(apart) > 80 and np.hypot(*(found - middle).T).min() > 95:
            return found


def _points(
    left: np.ndarray,
    middle: np.ndarray,
    crowns: np.ndarray,
    high: np.ndarray,
    moved: Callable[[np.ndarray, np.ndarray], np.ndarray],
    chance: np.random.RandomState,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Choose thirty points and four more; where the relief moves them, and their kind.

    On open ground no crown is near, and the better half of what is drawn is taken.
    """
    drawn = np.column_stack(
        [chance.randint(112, 412, 900), chance.randint(60, 260, 900)]
    )
    stands = np.concatenate([crowns + (15, 0), crowns - (20, 0)])  # in the right, too
    clear = np.abs(drawn - middle).max(axis=1) > STEP * TREES / 2 + 12
    clear &= np.hypot(*(drawn[:, None] - stands).T).min(axis=0) > RADIUS + 24
    drawn = drawn[clear]
    grip = np.array([_grip(left[r - 10 : r + 11, c - 10 : c + 11]) for c, r in drawn])
    chosen: list[np.ndarray] = []
    for one in drawn[grip > np.median(grip)]:
        if all(np.abs(one - other).max() > 8 for other in chosen) and len(chosen) < 40:
            chosen.append(one)
    ground = np.array(chosen)
    ground = ground[np.argsort(moved(*ground.T))]
    measured, ground = ground[[0, 20, 39]], np.delete(ground, [0, 20, 39], axis=0)
    which = np.array([0, 1, 2, 0, np.argmin(high[:, 0])])
    on_crowns = crowns[which] + chance.randint(-9, 10, (5, 2))
    deep = chance.randint(RADIUS + 8, RADIUS + 15, 6)
    behind = np.repeat(crowns, 2, axis=0) + np.column_stack(
        [-deep, chance.randint(-8, 9, 6)]
    )
    cells = chance.permutation(9)[:8]
    rows = middle + STEP * np.column_stack([cells % 3 - 1, cells // 3 - 1])
    points = np.concatenate(
        [ground[chance.permutation(37)[:12]], rows, on_crowns[:4], behind]
    )
    points = np.concatenate([points, measured, on_crowns[4:]])
    there = points + np.column_stack([moved(*points.T), 0 * points[:, 1]])
    there[20:24], there[33] = (
        (on_crowns + high[which])[:4],
        on_crowns[4] + high[which[4]],
    )
    return points, there, np.repeat(range(4), HOW_MANY)


def _grip(window: np.ndarray) -> float:
    """Return about how steep a window is in the direction in which it is flattest."""
    y, x = np.gradient(window)
    xx, yy, xy = np.mean(x * x), np.mean(y * y), np.mean(x * y)
    return float(np.sqrt((xx * yy - xy**2) / (xx + yy)))
