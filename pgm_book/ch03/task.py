"""The task of chapter 3: positions to a hundredth of a pixel, and how good they are."""

from dataclasses import dataclass
from functools import cached_property

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from scipy import ndimage, special

from pgm_book.common.checks import CheckFailed
from pgm_book.program import lsm
from pgm_book.program.adjustment import adjust
from pgm_book.task import Part, grey, named, table
from pgm_lab import datasets, plot

SIDE, WINDOW, POINTS, MARGIN = 480, 25, 80, 64
NOISE = 1.8, 1.25  # grey values, of the left and of the darker right photo
PIXEL, BLUR = 2.5, 2.5  # pixels of the orthophoto: a pixel of ours, and the lens
FARTHEST = 0.1  # px
LOW, HIGH = special.chdtri(2 * POINTS, [0.9995, 0.0005]) / (2 * POINTS)
WANTED = {
    "positions": (f"column and row of each in px, ({POINTS}, 2)", (POINTS, 2)),
    "covariances": (f"a covariance of each in px², ({POINTS}, 2, 2)", (POINTS, 2, 2)),
}
Pair = tuple[np.ndarray, np.ndarray]  # positions and covariances


@dataclass(frozen=True)
class Truth:
    """Two photos, points of the left one, and the transformation to the right one."""

    left: np.ndarray
    right: np.ndarray
    points: np.ndarray  # (80, 2): column, row
    affine: np.ndarray  # (2, 3)
    light: tuple[float, float]  # left = h0 + h1 right
    start: np.ndarray  # (80, 2)

    @property
    def there(self) -> np.ndarray:
        """The true positions in the right photo."""
        return self.points @ self.affine[:, :2].T + self.affine[:, 2]

    @cached_property
    def solved(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Parameters, sigma0 and Q: one step from the truth is the whole match."""
        half, found, A = WINDOW // 2, [], self.affine
        y, x = np.mgrid[-half : half + 1, -half : half + 1].reshape(2, -1)
        for (column, row), place in zip(self.points, self.there):
            p = np.array([place[0], *A[0, :2], place[1], *A[1, :2], *self.light])
            B, Bx, By = lsm.resampled(self.right, p, x, y)
            J = lsm.design(B, Bx, By, x, y, p[7])
            observed = self.left[row + y, column + x] - (p[6] + p[7] * B)
            step, _, sigma0, Q = adjust(J, np.ones(len(B)), observed)
            found.append((p + step, sigma0, Q))
        p, sigmas, cofactors = (np.array(part) for part in zip(*found))
        return p, sigmas[:, None, None], cofactors


def make(chance: np.random.RandomState) -> tuple[dict[str, str | np.ndarray], Truth]:
    """The real orthophoto twice, rotated and darker, and eighty points found by r."""
    c, r = chance.randint(1536 - 1400, size=2)
    part = datasets.yellowstone().grey[r : r + 1400, c : c + 1400]
    ortho = ndimage.gaussian_filter(part.astype(float), BLUR)
    turn = np.radians(chance.choice([-1, 1]) * chance.uniform(4, 8))
    scale, shear = chance.uniform(0.94, 1.06), chance.uniform(-0.03, 0.03)
    cos, sin = np.cos(turn), np.sin(turn)
    A = scale * np.array([[cos, -sin + shear], [sin, cos]])
    middle = np.full(2, (SIDE - 1) / 2)
    affine = np.column_stack([A, middle - A @ middle + chance.uniform(-6, 6, 2)])
    pixels = np.stack(np.meshgrid(*2 * [np.arange(SIDE)]), axis=-1).astype(float)
    back = (pixels - affine[:, 2]) @ np.linalg.inv(A).T
    gain, offset = chance.uniform(0.55, 0.75), chance.uniform(5, 25)
    photos = []
    for at, noise, (k, b) in zip((pixels, back), NOISE, ((1, 0), (gain, offset))):
        where = PIXEL * (at - middle) + 699.5
        values = ndimage.map_coordinates(ortho, [where[..., 1], where[..., 0]], order=3)
        values = b + k * values + noise * chance.standard_normal(values.shape)
        photos.append(grey(values))
    points = _points(photos[0], chance)
    there = points @ A.T + affine[:, 2]
    start = np.rint(there).astype(int)
    left, right = photos
    head, rows = "column,row,right_column,right_row", np.hstack([points, start])
    found = table(head, "{},{},{},{}", rows)
    truth = Truth(left, right, points, affine, (-offset / gain, 1 / gain), start)
    return {"left.png": left, "right.png": right, "start.csv": found}, truth


def _points(left: np.ndarray, chance: np.random.RandomState) -> np.ndarray:
    """Choose points apart from each other that can be matched well."""
    drawn = chance.randint(MARGIN, SIDE - MARGIN, (2000, 2))
    y, x = np.gradient(ndimage.gaussian_filter(1.0 * left, 1))
    xx, yy, xy = (ndimage.uniform_filter(g, WINDOW) for g in (x * x, y * y, x * y))
    grip = ((xx * yy - xy**2) / (xx + yy))[drawn[:, 1], drawn[:, 0]]
    drawn = drawn[np.argsort(-grip.round(6), kind="stable")]
    found = []
    while len(drawn):
        found.append(drawn[0])
        drawn = drawn[np.abs(drawn - drawn[0]).max(axis=1) >= WINDOW]
    half, sds = WINDOW // 2, []
    v, u = np.mgrid[-half : half + 1, -half : half + 1].reshape(2, -1)
    for column, row in found:
        B, Bx, By = (g[row + v, column + u] for g in (left, x, y))
        J = lsm.design(B, Bx, By, u, v, 1)
        sds.append(np.sqrt(np.trace(np.linalg.inv(J.T @ J)[::3, ::3][:2, :2])))
    order = np.argsort(np.round(sds, 6), kind="stable")
    return np.array(found)[order[:POINTS]]


def judge(truth: Truth, found: Pair) -> list[Part]:
    """Return how far the worst position is off, and whether the covariances are true.

    The errors by their covariances have a chi-square of 160 on average. Error ellipses
    are off by 0 if they lie as here, by 1 if they are circles, by 2 if they lie across.
    """
    (positions, covariances), (_, _, Q) = found, truth.solved
    e = positions - truth.there
    ratio = np.sum(e * np.linalg.solve(covariances, e[..., None])[..., 0]) / e.size
    uneven = zip(_uneven(covariances), _uneven(Q[:, ::3, ::3]))
    across, slanted = (1 - yours @ ours / (ours @ ours) for yours, ours in uneven)
    return [
        Part("the worst position", float(np.hypot(*e.T).max()), FARTHEST, "px"),
        Part("chi-square over 160", float(ratio), round(HIGH, 2), ""),
        Part("160 over chi-square", float(1 / ratio), round(1 / LOW, 2), ""),
        Part("column against row", across, 0.7, ""),
        Part("column with row", slanted, 0.7, ""),
    ]


def _uneven(C: np.ndarray) -> np.ndarray:
    """By how much error ellipses are longer than wide (2, n): across, and slanted."""
    part = np.array([C[:, 0, 0] - C[:, 1, 1], 2 * C[:, 0, 1]])
    part /= C[:, 0, 0] + C[:, 1, 1]
    return part - [[part[0].mean()], [0]]  # all alike say nothing of texture


def slips(truth: Truth) -> dict[str, Pair]:
    """Return what the likeliest wrong programs give."""
    p, sigma0, Q = truth.solved
    at, cofactors = p[:, [0, 3]], Q[:, ::3, ::3][:, :2, :2]
    C, first = sigma0**2 * cofactors, sigma0**2 * Q[:, :2, :2]
    return {
        "Q is not the covariance yet: it does not know the noise.": (at, cofactors),
        "The noise is counted once; a covariance has the unit px².": (at, C / sigma0),
        "Those are rows and columns of a0 and a1: the place is a0 and b0.": (at, first),
        "The variance of the column is C[0, 0].": (at, C[:, ::-1, ::-1]),
        "Variances alone: column and row have a covariance, too.": (at, C * np.eye(2)),
        "Those are still the positions of correlation.": (1.0 * truth.start, C),
        "Those are the points of the left photo.": (1.0 * truth.points, C),
        "Column and row are exchanged: column first.": (at[:, ::-1], C),
    }


def hint(truth: Truth, found: Pair, wrong: list[str]) -> str:
    """Return the hint to the slip that explains the result."""
    positions, covariances = found
    lost = "the worst position" in wrong
    for words, (at, C) in slips(truth).items():
        near = np.abs(positions - at).max() < 0.05
        size = np.trace(C, axis1=1, axis2=2).mean()
        if near and (lost or np.abs(covariances - C).max() < 0.2 * size):
            return words
    if not lost:
        return "Compare the errors that you expect of one point with its covariance."
    if np.ptp(positions - truth.there, axis=0).max() < 6 * FARTHEST:
        return "All are off by the same: where do columns and rows begin, at 0?"
    return (
        "At least one match ended in a wrong place, or was not carried to its end:"
        " look at its residuals. Where does the light start, h0 and h1?"
    )


def picture(truth: Truth, found: Pair) -> tuple[Figure, str]:
    """Draw the errors by their covariances, and the circle that holds 95 % of such."""
    positions, covariances = found
    e = positions - truth.there
    whitened = np.linalg.solve(np.linalg.cholesky(covariances), e[..., None])[..., 0]
    inside = np.sum(np.sum(whitened**2, axis=1) < special.chdtri(2, 0.05))
    fig, ax = plt.subplots(figsize=(7, 4.6), layout="constrained")
    plot.error_ellipse(ax, (0, 0), np.eye(2), color=plot.BLACK)
    ax.plot(*whitened.T, "o", color=plot.BLUE)
    ax.set(xlabel="first error / sd", ylabel="second error / sd", aspect="equal")
    ax.set_title(f"{inside} of your {POINTS} errors in the circle of 95 %", fontsize=14)
    return fig, f"{inside} of {POINTS} errors over their sd lie in the circle of 95 %."


def read(result: object) -> Pair:
    """Return positions (80, 2) and covariances (80, 2, 2) of an answer."""
    if not isinstance(result, tuple | list | dict) or len(result) != len(WANTED):
        raise CheckFailed("the result must be a pair, (positions, covariances)")
    positions, covariances = named(result, WANTED).values()
    if np.linalg.eigvalsh(covariances).min() <= 0:
        raise CheckFailed("every covariance needs positive variances")
    return positions, covariances
