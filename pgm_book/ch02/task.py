"""The task of chapter 2: thirty points of a photo, to be found in another one.

Both photos are cut from the real orthophoto. The ground is not flat, the crowns of high
trees stand over it, and one small tree was planted many times, in rows.
"""

from dataclasses import dataclass
from typing import Any

import cv2
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from scipy import ndimage

from pgm_book.common.checks import CheckFailed
from pgm_book.task import Part, grey, table
from pgm_lab import datasets, plot
from pgm_lab.plot.basic import Look

ROWS, COLUMNS = 320, 460
BLUR, NOISE = 0.5, 2.0  # px, of the lens, and grey values
SEEN, PLANTED, CROWN, HIDDEN = range(4)  # kinds of points
HOW_MANY = 12, 8, 4, 6
RADIUS, STEP, TREES = 24, 9, 9  # px: of a high crown, and between the small trees
MIDDLE = np.array([260, 160])  # of their rows; the crowns stand around them
CROWNS = np.array([(150, 90), (375, 90), (375, 235)])
ALLOWED = 12  # points of thirty, wrong ones counted twice
FORM = "30 rows of (column, row) in the right photo, NaN where a point has no match"

EVERY = (
    "Points that the right photo hides have a pixel. A search always finds a highest r:"
    " how high is it there, and does the search back end where it began?"
)
REPEATED = (
    "Look at the points among the rows of small trees: how high is the second summit of"
    " their maps of r?"
)
STRICT = (
    "Points that both photos show are missing. Does the search window hold all four"
    " matches in `known` (a shift is right minus left)? How high is r at points that"
    " you see in both photos?"
)
SWAPPED = "Column and row are exchanged: column first."
STILL = "Those are pixels of the left photo."
SHIFT = "Those are shifts; the pixel in the right photo is wanted."
REVERSED = "A shift leads from the left photo to the right one: right minus left."
BESIDE = (
    "All pixels are off by the same amount. Is the pixel the centre of the template,"
    " and where does the map of r begin?"
)
OTHERWISE = (
    "Some pixels are wrong: draw the map of r for a point that you trust, and for one"
    " that you do not. A large template reaches over the edge of a crown."
)
Found = tuple[np.ndarray, np.ndarray]  # pixels (30, 2), and in which rows there is one


@dataclass(frozen=True)
class Truth:
    """Two photos, thirty points of the left one, and where the right one has them."""

    left: np.ndarray
    right: np.ndarray
    points: np.ndarray  # (30, 2): column, row
    there: np.ndarray  # (30, 2), of hidden ones, too
    kind: np.ndarray  # (30,): SEEN, PLANTED, CROWN or HIDDEN

    def right_ones(self, found: np.ndarray) -> np.ndarray:
        """Which pixels are at most 1 px off, in column and in row."""
        off = np.abs(found - self.there).max(axis=1)
        return (off <= 1) & (self.kind != HIDDEN)


def make(chance: np.random.RandomState) -> tuple[dict[str, str | np.ndarray], Truth]:
    """Two photos, thirty points, and four more that were measured in both."""
    ground, tree = _cut(chance, 580, 440), _cut(chance, STEP, STEP)
    mask, half = _disc(STEP, STEP / 2 - 1), STEP * TREES // 2
    tree = 40 + 80 * mask * (tree - tree.min()) / np.ptp(tree) + 100 * (1 - mask)
    c, r = MIDDLE + 60 - half
    ground[r : r + STEP * TREES, c : c + STEP * TREES] = np.tile(tree, (TREES, TREES))

    shift = np.array([chance.randint(-38, -9), chance.randint(-9, 10)])
    phase, length = chance.uniform(0, 2 * np.pi), chance.uniform(330, 400)

    def moved(y: np.ndarray) -> np.ndarray:
        """By how many columns the relief moves the ground."""
        return 6 * np.sin(2 * np.pi * y / length + phase)

    row, column = np.indices((ROWS, COLUMNS)).astype(float)
    y = row - shift[1]
    seen = (row, column), (y, column - shift[0] - moved(y))
    photos = [ndimage.map_coordinates(ground, np.add(one, 60), order=3) for one in seen]
    crowns = CROWNS + chance.randint(-15, 16, (3, 2))
    high = np.rint(moved(crowns[:, 1])).astype(int) - chance.randint(22, 28, 3)
    for k, centre in enumerate(crowns):
        top, mask = _cut(chance, 50, 50), _disc(50, RADIUS)
        for photo, (c, r) in zip(photos, (centre, centre + (high[k], 0) + shift)):
            part = photo[r - 25 : r + 25, c - 25 : c + 25]
            part += (top - top.mean() + part.mean() - part) * mask
    light = chance.uniform(35, 60) + chance.uniform(0.5, 0.7) * photos[1]
    photos[1] = light * (1.1 - 0.2 * column / COLUMNS)
    left, right = (grey(g + NOISE * chance.standard_normal(g.shape)) for g in photos)

    which = np.array([0, 1, 2, 0, np.argmin(high)])
    on_crowns = crowns[which] + chance.randint(-6, 7, (5, 2))
    cells = chance.permutation(9)[: HOW_MANY[PLANTED]]
    trees = MIDDLE + STEP * np.column_stack([cells % 3 - 1, cells // 3 - 1])
    away = chance.randint(RADIUS + 11, RADIUS + 15, 6), chance.randint(-8, 9, 6)
    behind = np.repeat(crowns, 2, axis=0) + np.transpose(away) * (-1, 1)
    free = _ground(left, crowns, chance)
    free = free[np.argsort(moved(free[:, 1]))]
    extreme, free = free[[0, 7, 14]], np.delete(free, [0, 7, 14], axis=0)
    points = np.concatenate(
        [free, trees, on_crowns[:4], behind, extreme, on_crowns[4:]]
    )
    there = points + shift + np.column_stack([moved(points[:, 1]), np.zeros(34)])
    tops = [20, 21, 22, 23, 33]
    there[tops, 0] = points[tops, 0] + shift[0] + high[which]

    known = np.rint(np.hstack([points, there])[30:]).astype(int)
    order, kind = chance.permutation(30), np.repeat(range(4), HOW_MANY)
    known_head = "left_column,left_row,right_column,right_row"
    return {
        "left.png": left,
        "right.png": right,
        "points.csv": table("column,row", "{},{}", points[order]),
        "known.csv": table(known_head, "{},{},{},{}", known),
    }, Truth(left, right, points[order], there[order], kind[order])


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


def _ground(
    left: np.ndarray, crowns: np.ndarray, chance: np.random.RandomState
) -> np.ndarray:
    """Choose fifteen points of open ground, where no crown is near, of good texture."""
    places = np.mgrid[112:412:9, 60:260:9].reshape(2, -1).T
    stands = np.concatenate([crowns + (15, 0), crowns - (20, 0)])  # in the right, too
    clear = np.abs(places - MIDDLE).max(axis=1) > STEP * TREES / 2 + 12
    clear &= np.hypot(*(places[:, None] - stands).T).min(axis=0) > RADIUS + 24
    column, row = places[clear].T
    texture = cv2.cornerMinEigenVal(left, 21)[row, column]
    return chance.permutation(places[clear][texture > np.median(texture)])[:15]


def judge(truth: Truth, found: Found) -> list[Part]:
    """Return how many points are missing, the wrong ones counted twice."""
    pixels, given = found
    right = truth.right_ones(pixels)
    missing, wrong = ~given & (truth.kind != HIDDEN), np.sum(given & ~right)
    lost = np.sum(missing) + 2 * wrong
    words = f"{np.sum(missing)} missing, {wrong} wrong (each counts 2)"
    trees = np.sum(missing & (truth.kind == PLANTED))
    if trees > 4 and lost <= ALLOWED:
        words = (
            f"{trees} points among the small trees are missing: for these alone, a"
            f" template as wide as their rows finds most, with r of only 0.5; {words}"
        )
    return [Part(words, float(lost), ALLOWED, "lost")]


def read(result: Any) -> Found:
    """Return an answer as (30, 2), and in which rows there is a pixel."""
    try:
        found = np.array(result, dtype=float)
    except (TypeError, ValueError):
        raise CheckFailed(f"the result must be {FORM}") from None
    if found.shape != (30, 2):
        raise CheckFailed(f"the result must be {FORM}; got {found.shape}")
    return found, np.isfinite(found).all(axis=1)


def slips(truth: Truth) -> dict[str, np.ndarray]:
    """Return what the likeliest wrong programs give."""
    best = np.rint(truth.there)
    best[truth.kind == HIDDEN] = np.nan
    guessed, strict, all_given = best.copy(), best.copy(), np.rint(truth.there)
    trees = np.flatnonzero(truth.kind == PLANTED)
    guessed[trees, 0] += STEP
    all_given[trees[:5], 0] += STEP  # some of them are found by chance
    strict[truth.kind != CROWN] = np.nan
    return {
        EVERY: all_given,
        REPEATED: guessed,
        STRICT: strict,
        SWAPPED: best[:, ::-1],
        STILL: 1.0 * truth.points,
        SHIFT: best - truth.points,
        REVERSED: 2 * truth.points - best,
        BESIDE: best - 10,
    }


def hint(truth: Truth, found: Found, _: list[str]) -> str:
    """Return the hint to what most points suffer from."""
    (pixels, given), hidden = found, truth.kind == HIDDEN
    wrong, seen = given & ~truth.right_ones(pixels), given & ~hidden
    if np.sum(wrong & seen) > np.sum(seen) / 2:
        by = np.median((pixels - truth.there)[seen], axis=0)
        to_the_right = np.median((pixels - truth.points)[seen, 0]) > 0  # no shift leads
        mended = {
            SWAPPED: pixels[:, ::-1],
            STILL: pixels - truth.points + truth.there,
            SHIFT: pixels + truth.points,
            REVERSED: truth.there if to_the_right else pixels,
            BESIDE: pixels - by,
        }
        for words, other in mended.items():
            if np.sum(truth.right_ones(other) & seen) > np.sum(seen) / 2:
                return words
    kinds = {EVERY: HIDDEN, REPEATED: PLANTED}
    number = {w: np.sum(wrong & (truth.kind == kind)) for w, kind in kinds.items()}
    words = max(number, key=number.__getitem__)
    if number[words] >= 2:
        return words
    shown = (truth.kind == SEEN) | (truth.kind == CROWN)
    return STRICT if np.sum(~given & shown) > 2 * np.sum(wrong) else OTHERWISE


def picture(truth: Truth, found: Found) -> tuple[Figure, str]:
    """Draw all points in both photos: right, wrong, missing, rightly left out."""
    (pixels, given), hidden = found, truth.kind == HIDDEN
    right = truth.right_ones(pixels)
    groups = (
        ("right", right, "o", plot.SKY),
        ("wrong", given & ~right, "X", plot.RED),
        ("missing", ~given & ~hidden, "s", plot.ORANGE),
        ("hidden, left out", ~given & hidden, "D", plot.GREEN),
    )
    labels = [f"{np.sum(chosen)} {name}" for name, chosen, *_ in groups]
    fig, axes = plt.subplots(1, 2, figsize=(10, 4.4))
    photos = (truth.left, truth.points, "left"), (truth.right, truth.there, "right")
    for ax, (photo, at, name) in zip(axes, photos):
        ax.imshow(photo // 24, interpolation="nearest")  # a small file
        for _, chosen, mark, colour in groups:
            look: Look = {"color": colour, "ls": "none", "ms": 9, "mec": "black"}
            ax.plot(*at[chosen].T, mark, **look)
        ax.set(title=name, xticks=[], yticks=[])
    fig.legend(axes[0].lines, labels, loc="outside lower center", ncols=4)
    return fig, (
        f"Both photos with the thirty points at their true places: {', '.join(labels)}."
        " Rows of small trees look alike; hidden points lie to the left of high crowns."
    )
