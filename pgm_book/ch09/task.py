"""The task of chapter 9: a telephone, a board of paper, and the edge of a cupboard."""

from dataclasses import dataclass
from functools import cached_property

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from pgm_book.ch09.photos import PIXEL, Board, grid, measured
from pgm_book.common.checks import CheckFailed
from pgm_book.program.bundle import adjust, without_lens
from pgm_book.program.camera import derivatives, project
from pgm_book.program.orientation import relative
from pgm_book.program.surface import base_length, flat_board
from pgm_book.task import Part, named, table
from pgm_lab import frames, plot
from pgm_lab.rotation import angles, matrix

SIZE, CORNERS, SIGMA = (1200, 900), (8, 6), 0.15  # px; inner corners; px
RULE = 0.5  # m
TILTS = ((0, 0), (0.6, 0), (-0.6, 0), (0, 0.6), (0, -0.6), (0.45, 0.45))
FLAT = "A board of paper is not flat: let its corners be unknowns."
WANTED = {
    "c": ("one number in pixels", ()),
    "sd": ("one number in pixels", ()),
    "PQ": ("one number in metres", ()),
}


@dataclass(frozen=True)
class Truth:
    """The telephone, what was measured, and how long the edge is."""

    c: float  # px
    edge: float  # m
    board: np.ndarray  # (photos, corners, 2), px
    cupboard: np.ndarray  # (points, 4), px

    @cached_property
    def seen(self) -> Board:
        """The photos of the board, as a set."""
        return Board("phone", self.board, SIZE, grid(*CORNERS))

    @cached_property
    def best(self) -> tuple[np.ndarray, np.ndarray]:
        """Camera and its covariance for the stated sigma, the corners unknown."""
        xy = _xy(self.board)
        photo, point = np.indices(xy.shape[:2]).reshape(2, -1)
        rays = photo, point, xy.reshape(-1, 2), SIGMA * PIXEL[0]
        camera, C, sigma0, _ = adjust(*rays, *self.seen.start, self.seen.grid)
        return camera, C / sigma0**2

    @cached_property
    def flat(self) -> tuple[np.ndarray, np.ndarray]:
        """The same with the board as it was printed, which it is not."""
        return flat_board(_xy(self.board), *self.seen.start, self.seen.grid)[:2]

    @cached_property
    def sd(self) -> tuple[float, float]:
        """Standard deviations of c (px) and of the edge (m)."""
        camera, C = self.best

        def edge(unknowns: np.ndarray) -> np.ndarray:
            return np.array(_edge(unknowns[10:].reshape(-1, 4), unknowns[:10]))

        J = derivatives(edge, np.append(camera, self.cupboard)).ravel()
        variance = J[:10] @ C @ J[:10] + SIGMA**2 * np.sum(J[10:] ** 2)
        return float(np.sqrt(C[0, 0]) / PIXEL[0]), float(np.sqrt(variance))


# --- What is given ---


def make(chance: np.random.RandomState) -> tuple[dict[str, str], Truth]:
    """Photos of a bent board and of a cupboard, by one telephone."""
    camera = np.array([1.0, *np.zeros(9)])
    camera[:3] += chance.uniform(-1, 1, 3) * (0.06, 0.01, 0.01)
    camera[3:5] = chance.uniform(0.1, 0.16) * chance.choice([-1, 1]), 0.02
    camera[6:8] = chance.uniform(-0.002, 0.002, 2)
    board = _paper(chance)
    shown = np.array([_photo(board, k, camera, chance) for k in range(12)])
    shown = np.round(shown + SIGMA * chance.standard_normal(shown.shape), 2)
    points, right = _cupboard(chance)
    pair = np.hstack([_pixels(e, points, camera) for e in (np.zeros(6), right)])
    pair = np.round(pair + SIGMA * chance.standard_normal(pair.shape), 2)
    corners = [(i, j, *xy) for i, p in enumerate(shown, 1) for j, xy in enumerate(p, 1)]
    numbered = [(k, *four) for k, four in enumerate(pair, 1)]
    head = "point,left_column,left_row,right_column,right_row"
    files = {
        "board.csv": table("photo,corner,column,row", "{},{},{:.2f},{:.2f}", corners),
        "cupboard.csv": table(head, "{}" + 4 * ",{:.2f}", numbered),
    }
    edge = float(np.linalg.norm(points[3] - points[2]))
    return files, Truth(float(camera[0]) / PIXEL[0], edge, shown, pair)


def _paper(chance: np.random.RandomState) -> np.ndarray:
    """Corners (48, 3) of a board that is bent, twisted, and printed roughly."""
    board = grid(*CORNERS) + 0.004 * chance.standard_normal((48, 3))
    x, y = (board[:, 0] - 3.5) / 3.5, (board[:, 1] + 2.5) / 2.5
    bend, twist = chance.uniform(0.04, 0.07), chance.uniform(-0.03, 0.03)
    board[:, 2] += bend * chance.choice([-1, 1]) * x**2 + twist * x * y
    return board


def _photo(
    board: np.ndarray, k: int, camera: np.ndarray, chance: np.random.RandomState
) -> np.ndarray:
    """Pixels (48, 2) of the board in a photo, every other one turned by 90 degrees."""
    omega, phi = np.add(TILTS[k // 2], chance.uniform(-0.06, 0.06, 2))
    M = matrix(omega, phi, np.pi / 2 * (k % 2) + chance.uniform(-0.1, 0.1))
    distance = chance.uniform(6.5, 7.5)
    while True:  # farther away, until all of the board is in the photo
        centre = (3.5, -2.5, 0) + M[2] * distance
        pixels = _pixels(np.concatenate([centre, angles(M)]), board, camera)
        if np.all((pixels > 15) & (pixels < np.subtract(SIZE, 16))):
            return pixels
        distance += 0.3


def _cupboard(chance: np.random.RandomState) -> tuple[np.ndarray, np.ndarray]:
    """Points (16, 3) in m, and the right photo (6,), as the left camera sees them."""
    X, Y = np.meshgrid((-0.6, -0.2, 0.25, 0.65), (0.45, 0.15, -0.15, -0.45))
    depth = 1.7 + 0.4 * chance.randint(0, 2, 16)
    points = np.column_stack([X.ravel(), Y.ravel(), -depth])
    points += chance.uniform(-0.06, 0.06, (16, 3))
    points = points[chance.permutation(16)]
    points[0] = (-0.25, 0, -1.75) + chance.uniform(-0.05, 0.05, 3)
    way = np.append(1, chance.uniform(-0.2, 0.2, 2))
    points[1] = points[0] + RULE * way / np.linalg.norm(way)
    points[2] = (-0.6, 0.42, -1.8) + chance.uniform(-0.08, 0.08, 3)
    points[3] = (0.75, -0.42, -1.75) + chance.uniform(-0.08, 0.08, 3)
    base = np.array([0.45, 0, 0]) + chance.uniform(-0.04, 0.04, 3)
    turn = (0, 0.2, 0) + chance.uniform(-0.06, 0.06, 3)
    return points, np.concatenate([base, turn])


def _pixels(exterior: np.ndarray, points: np.ndarray, camera: np.ndarray) -> np.ndarray:
    xy = measured(project(exterior, points, camera[0]), camera)
    return frames.photo_to_pixel(xy, SIZE, PIXEL)


def _xy(pixels: np.ndarray) -> np.ndarray:
    return frames.pixel_to_photo(pixels, SIZE, PIXEL)


def _edge(cupboard: np.ndarray, camera: np.ndarray) -> float:
    """Length of the edge in m, as a camera measures it."""
    left, right = (without_lens(_xy(cupboard[:, k : k + 2]), camera) for k in (0, 2))
    c = camera[0]
    exterior = relative(left, right, c)
    base = base_length(exterior, left[:2], right[:2], c, RULE)
    return base / base_length(exterior, left[2:4], right[2:4], c, 1.0)


# --- What is handed in ---


def judge(truth: Truth, result: object) -> list[Part]:
    """Return how far camera and edge are off, in standard deviations."""
    c, sd, edge = _read(result)
    sd_c, sd_edge = truth.sd
    return [
        Part("c", abs(c - truth.c) / sd_c),
        Part("sd, off by a factor of", max(sd / sd_c, sd_c / sd), 1.15, ""),
        Part("PQ", abs(edge - truth.edge) / sd_edge),
    ]


def _read(result: object) -> tuple[float, float, float]:
    """Return c, its standard deviation and PQ; or say what is wanted."""
    c, sd, edge = named(result, WANTED).values()
    if not min(c, sd, edge) > 0:
        raise CheckFailed("c, sd and PQ must be positive")
    return float(c), float(sd), float(edge)


def slips(truth: Truth) -> dict[str, dict[str, float]]:
    """Return what the likeliest wrong programs give."""
    camera, right = truth.best[0], _answer(truth, *truth.best)
    ideal = np.array([camera[0], *np.zeros(9)])
    return {
        FLAT: _answer(truth, *truth.flat),
        "The unit: c and its standard deviation are wanted in pixels.": (
            right | {name: right[name] * PIXEL[0] for name in ("c", "sd")}
        ),
        "The diagonal of C holds variances, in mm²: its root comes first.": (
            right | {"sd": right["sd"] ** 2 * PIXEL[0]}
        ),
        "PQ is upside down: it is longer than the rule.": (
            right | {"PQ": RULE**2 / right["PQ"]}
        ),
        "The points of the cupboard still have the distortion of the lens.": (
            right | {"PQ": _edge(truth.cupboard, ideal)}
        ),
    }


def _answer(truth: Truth, camera: np.ndarray, C: np.ndarray) -> dict[str, float]:
    """What a camera and its covariance give, as it is handed in."""
    c, sd = camera[0] / PIXEL[0], np.sqrt(C[0, 0]) / PIXEL[0]
    return {"c": c, "sd": sd, "PQ": _edge(truth.cupboard, camera)}


def hint(truth: Truth, result: object) -> str:
    """Return the hint to the slip that explains the result."""
    found = np.array(_read(result))
    for words, wrong in slips(truth).items():
        off = np.abs(found / [wrong["c"], wrong["sd"], wrong["PQ"]] - 1)
        if np.all(off < (2e-4, 0.05, 5e-4)):
            return words
    if abs(found[0] - truth.flat[0][0] / PIXEL[0]) < truth.sd[0]:
        return FLAT
    return (
        "Test the parts: sigma0 of the board should be near 0.15 px, the y parallaxes"
        " of the cupboard as well, and the rule must come out as long as it is."
    )


def picture(truth: Truth, result: object) -> tuple[Figure, str]:
    """Draw both results beside the truth, and a flat board's."""
    c, _, edge = _read(result)
    flat = _answer(truth, *truth.flat)
    both = np.array([(c, edge), (flat["c"], flat["PQ"])])
    yours, bent = (both - (truth.c, truth.edge)) / truth.sd
    fig, ax = plt.subplots(figsize=(10, 4), layout="constrained")
    ax.axvspan(-3, 3, color="0.9", label="± 3 standard deviations")
    ax.axvline(0, color=plot.ORANGE, label="true")
    ax.plot(yours, (1, 0), "o", color=plot.BLUE, ms=12, label="yours")
    ax.plot(bent, (1, 0), "X", color=plot.RED, ms=12, label="by a flat board")
    ax.set_yticks([1, 0], [f"c = {c:.1f} px", f"PQ = {1000 * edge:.1f} mm"])
    ax.set(ylim=(-0.5, 1.5), xlabel="error (standard deviations)")
    ax.legend()
    return fig, (
        f"The errors of c, {yours[0]:.1f}, and of PQ, {yours[1]:.1f} standard"
        f" deviations, in a band of three; by a flat board {bent[0]:.1f} and"
        f" {bent[1]:.1f}."
    )
