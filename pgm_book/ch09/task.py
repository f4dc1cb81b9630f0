"""The task of chapter 9: a telephone, a board of paper, and the edge of a cupboard."""

from dataclasses import dataclass
from functools import cached_property, partial

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from scipy.optimize import approx_fprime

from pgm_book.ch09.photos import PIXEL, Board, grid, measured
from pgm_book.program.bundle import adjust, without_lens
from pgm_book.program.camera import project
from pgm_book.program.orientation import relative
from pgm_book.program.surface import base_length, flat_board
from pgm_book.task import Answer, Part, likeliest, named, table
from pgm_lab import frames
from pgm_lab.rotation import angles, matrix

SIZE, SIGMA, RULE = (1200, 900), 0.15, 0.5  # px, px, m
TILTS = ((0, 0), (0.6, 0), (-0.6, 0), (0, 0.6), (0, -0.6), (0.45, 0.45))
PIXELS = ("one number in pixels", ())
WANTED = {"c": PIXELS, "sd": PIXELS, "PQ": ("one number in metres", ())}
read = partial(named, wanted=WANTED)
OTHERWISE = {
    "c": "Look at sigma0 of the board: it should be near 0.15 px.",
    "sd, off by a factor of": "sd is the root of C[0, 0], of all photos, in pixels.",
    "PQ": "Measure the rule, too. If it is right: which camera, image size and rows?",
}


@dataclass(frozen=True)
class Truth:
    """The telephone, what was measured, and how long the edge is."""

    c: float  # px
    edge: float  # m
    seen: Board
    cupboard: np.ndarray  # (points, 4), px
    base: float  # its length in units of its X

    @cached_property
    def answer(self) -> Answer:
        """What is right, with the standard deviation of an ideal solution."""
        return {"c": self.c, "sd": self.sd[0], "PQ": self.edge}

    @cached_property
    def best(self) -> tuple[np.ndarray, np.ndarray]:
        """Camera and its covariance for the stated sigma, the corners unknown."""
        photo, point = np.indices(self.seen.xy.shape[:2]).reshape(2, -1)
        rays = photo, point, self.seen.xy.reshape(-1, 2), SIGMA * PIXEL[0]
        camera, C, sigma0, _ = adjust(*rays, *self.seen.start, self.seen.grid)
        return camera, C / sigma0**2

    @cached_property
    def flat(self) -> Answer:
        """What the board as it was printed gives, which it is not."""
        return self.given(*flat_board(self.seen.xy, *self.seen.start, self.seen.grid))

    @cached_property
    def sd(self) -> np.ndarray:
        """Standard deviations of c (px) and of the edge (m)."""
        camera, C = self.best
        at = np.append(camera, self.cupboard)
        J = approx_fprime(at, lambda u: _edge(u[10:].reshape(-1, 4), u[:10]), 1e-6)
        edge = J[:10] @ C @ J[:10] + SIGMA**2 * np.sum(J[10:] ** 2)
        return np.sqrt([C[0, 0] / PIXEL[0] ** 2, edge])

    def given(self, camera: np.ndarray, C: np.ndarray, *_: float) -> Answer:
        """What a camera and its covariance give, as it is handed in."""
        c, sd = camera[0] / PIXEL[0], np.sqrt(C[0, 0]) / PIXEL[0]
        return {"c": c, "sd": sd, "PQ": _edge(self.cupboard, camera)}


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
    four = [(k, *row) for k, row in enumerate(pair, 1)]
    head, one = "point,left_column,left_row,right_column,right_row", ",{:.2f}"
    files = {
        "board.csv": table("photo,corner,column,row", "{},{}" + 2 * one, corners),
        "cupboard.csv": table(head, "{}" + 4 * one, four),
    }
    edge, base = map(np.linalg.norm, (points[3] - points[2], right[:3] / right[0]))
    off = [abs(_edge(pair, k * camera) / edge - 1) for k in (1, np.eye(10)[0])]
    phone = Board("phone", shown, SIZE, grid(8, 6))
    off += [abs(phone.start[0][0] - camera[0])]
    # `relative` is lost, the lens hardly shows, or c is its start value
    if off[0] > 0.01 or off[1] < 0.006 or off[2] < 0.003:
        return make(chance)
    return files, Truth(camera[0] / PIXEL[0], float(edge), phone, pair, float(base))


def _paper(chance: np.random.RandomState) -> np.ndarray:
    """Corners (48, 3) of a board that is bent, twisted, and printed roughly."""
    board = grid(8, 6) + 0.004 * chance.standard_normal((48, 3))
    x, y = (board[:, 0] - 3.5) / 3.5, (board[:, 1] + 2.5) / 2.5
    bend, twist = chance.uniform(0.14, 0.17), chance.uniform(-0.03, 0.03)
    board[:, 2] += bend * chance.choice([-1, 1]) * x**2 + twist * x * y
    return board


def _photo(
    board: np.ndarray, k: int, camera: np.ndarray, chance: np.random.RandomState
) -> np.ndarray:
    """Pixels (48, 2) of the board in a photo, every other one turned by 90 degrees."""
    omega, phi = np.add(TILTS[k // 2], chance.uniform(-0.06, 0.06, 2))
    M = matrix(omega, phi, np.pi / 2 * (k % 2) + chance.uniform(-0.1, 0.1))
    pixels, distance = np.zeros((48, 2)), chance.uniform(6.2, 7.2)
    while np.any((pixels < 16) | (pixels > np.subtract(SIZE, 17))):  # not all is seen
        distance += 0.3
        exterior = np.concatenate([(3.5, -2.5, 0) + M[2] * distance, angles(M)])
        pixels = _pixels(exterior, board, camera)
    return pixels


def _cupboard(chance: np.random.RandomState) -> tuple[np.ndarray, np.ndarray]:
    """Points (16, 3) in m, and the right photo (6,), as the left camera sees them."""
    points = chance.uniform((-0.7, -0.5, -2.1), (0.7, 0.5, -1.65), (16, 3))
    ends = np.array([(-0.25, 0, -1.75), (-0.6, 0.42, -1.8), (0.75, -0.42, -1.75)])
    points[[0, 2, 3]] = ends + chance.uniform(-0.07, 0.07, (3, 3))
    way = np.append(1, chance.uniform(-0.2, 0.2, 2))
    points[1] = points[0] + RULE * way / np.linalg.norm(way)
    right = (0.45, 0.15, 0, 0, 0.18, 0) + chance.uniform(-0.05, 0.05, 6)
    return points, right


def _pixels(exterior: np.ndarray, points: np.ndarray, camera: np.ndarray) -> np.ndarray:
    xy = measured(project(exterior, points, camera[0]), camera)
    return frames.photo_to_pixel(xy, SIZE, PIXEL)


def _edge(cupboard: np.ndarray, camera: np.ndarray) -> float:
    """Length of the edge in m, as a camera measures it."""
    xy = frames.pixel_to_photo(cupboard.reshape(-1, 2), SIZE, PIXEL)
    left, right = without_lens(xy, camera).reshape(-1, 2, 2).swapaxes(0, 1)
    e = relative(left, right, camera[0])
    base = base_length(e, left[:2], right[:2], camera[0], RULE)
    return base / base_length(e, left[2:4], right[2:4], camera[0], 1.0)


def judge(truth: Truth, found: Answer) -> list[Part]:
    """Return how far camera and edge are off, in standard deviations."""
    (c, sd, edge), right = found.values(), truth.answer
    factor = max(sd / right["sd"], right["sd"] / sd) if sd > 0 else np.inf
    return [
        Part("c", abs(c - right["c"]) / truth.sd[0]),
        Part("sd, off by a factor of", factor, 1.15, ""),
        Part("PQ", abs(edge - right["PQ"]) / truth.sd[1]),
    ]


def slips(truth: Truth) -> dict[str, Answer]:
    """Return what the likeliest wrong programs give."""
    camera, (c, sd, edge) = truth.best[0], truth.given(*truth.best).values()
    bent = _edge(truth.cupboard, np.array([camera[0], *np.zeros(9)]))
    parts = {
        "c": {
            "Paper is not flat: let the corners be unknowns.": truth.flat["c"],
            "c is in mm. Wanted are pixels, for sd as well.": c * PIXEL[0],
            "c is still its start value.": truth.seen.start[0][0] / PIXEL[0],
        },
        "sd": {
            "sd is in mm. Wanted are pixels.": sd * PIXEL[0],
            "sd is a variance: its root is wanted.": sd**2,
            "C has variances in mm²: first the root, then pixels.": sd**2 * PIXEL[0],
            "sd is a flat board's, or divided by sigma0: do neither.": truth.flat["sd"],
            "sigma0 is in C: do not divide by it, or take a flat board's.": sd / SIGMA,
            "sigma0 is in C already: do not multiply by it.": sd * SIGMA,
        },
        "PQ": {
            "PQ is in mm. Wanted are metres.": 1000 * edge,
            "The rule is 0.5 m long, not 1 m.": edge / RULE,
            "The model's unit is the X of the base, not its length.": edge * truth.base,
            "PQ is upside down: it is longer than the rule.": RULE**2 / edge,
            "The points of the cupboard are not yet corrected for the lens.": bent,
            "Point 1 is in row 0.": _edge(np.roll(truth.cupboard, -1, 0), camera),
        },
    }
    rows = ((key, row) for key, part in parts.items() for row in part.items())
    return {words: {key: value} for key, (words, value) in rows}


def hint(truth: Truth, found: Answer, wrong: list[str]) -> str:
    """Return the hint to the slip that explains a wrong part."""
    return likeliest(judge, truth, found, wrong, slips(truth)) or OTHERWISE[wrong[0]]


def picture(truth: Truth, found: Answer) -> tuple[Figure, str]:
    """Draw both results beside the truth, and a flat board's."""
    both = {"yours": found, "by a flat board": truth.flat}
    fig, ax = plt.subplots(figsize=(10, 4), layout="constrained")
    ax.axvspan(-3, 3, color="0.9", label="± 3 standard deviations")
    off = []
    for mark, (name, one) in zip("oX", both.items()):
        off += [np.subtract([one["c"], one["PQ"]], [truth.c, truth.edge]) / truth.sd]
        ax.plot(off[-1], ["c", "PQ"], mark, ms=12, label=name)
    ax.set(ylim=(-0.5, 1.5), xlabel="error (standard deviations)")
    ax.set_title("The rule takes most of a flat board's error out of PQ")
    ax.legend(loc="center")
    said = "c is off by {:.1f}, PQ by {:.1f} standard deviations, of three allowed;"
    said += " by a flat board {:.1f} and {:.1f}."
    return fig, said.format(*off[0], *off[1])
