"""The task of chapter 4: from a drone's yaw, pitch and roll to the book's angles."""

from dataclasses import dataclass

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from pgm_book.ch04 import figures
from pgm_book.common.checks import near
from pgm_book.task import Part, named, table
from pgm_lab import frames, plot, rotation
from pgm_lab.plot import space

SIZE, PIXEL, PHOTOS = (4000, 3000), 0.004, 6  # the camera, pixels in mm; and how many
SIDES = {"right": np.pi / 2, "left": -np.pi / 2}  # from forward, about the z axis down
SD = np.radians(0.01) / np.sqrt(12)  # of an angle that is rounded to 0.01 degrees
DOWN = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1]])  # north, east, down of E, N, up
WANTED = {
    "angles": ("omega, phi, kappa in degrees, one row a photo", (PHOTOS, 3)),
    "M": ("one M (3, 3) a photo", (PHOTOS, 3, 3)),
    "row": ("the row of the horizon in each photo", (PHOTOS,)),
}


@dataclass(frozen=True)
class Truth:
    """The drone at each photo, and how its camera is fixed to it; angles in radians."""

    drone: np.ndarray  # (6, 3): yaw, pitch, roll, with all digits
    written: np.ndarray  # the same, as the autopilot rounds it
    side: float
    below: float
    c: float  # mm

    def M(self, drone: np.ndarray) -> np.ndarray:
        """Rotation matrices (6, 3, 3) of the camera."""
        return _mounted(self.side, self.below) @ _turned(drone) @ DOWN

    def row(self, M: np.ndarray) -> np.ndarray:
        """Rows where the horizon crosses the middle column: (0, y, -c) is level."""
        return _rows(self.c * M[:, 2, 2] / M[:, 1, 2])

    @property
    def sd(self) -> np.ndarray:
        """Standard deviations (6,) of the rows in pixels, from the rounded angles."""
        steps = 1e-6 * np.eye(3)
        there, back = (
            np.array([self.row(self.M(self.drone + sign * step)) for step in steps])
            for sign in (1, -1)
        )
        return SD * np.linalg.norm((there - back) / 2e-6, axis=0)


def make(chance: np.random.RandomState) -> tuple[dict[str, str], Truth]:
    """Six photos of a drone that flies along a coast and looks to one side."""
    side = list(SIDES)[chance.randint(2)]
    below = round(chance.uniform(10, 20), 1)
    c = round(chance.uniform(8.5, 9.5), 2)
    yaw = chance.uniform(0, 360, PHOTOS)
    pitch, roll = chance.uniform(2, 8, (2, PHOTOS)) * chance.choice([-1, 1], (2, 6))
    drone = np.column_stack([yaw, pitch, roll])
    written = np.round(drone, 2)
    rows = [(k, *angles) for k, angles in enumerate(written, 1)]
    form = "{}" + 3 * ",{:.2f}"
    attitude = table("photo,yaw_deg,pitch_deg,roll_deg", form, rows)
    camera = "looks,below_deg,c_mm,columns,rows,pixel_mm\n"
    camera += f"{side},{below:.1f},{c:.2f},{SIZE[0]},{SIZE[1]},{PIXEL}\n"
    truth = Truth(
        np.radians(drone), np.radians(written), SIDES[side], np.radians(below), c
    )
    return {"attitude.csv": attitude, "camera.csv": camera}, truth


def judge(truth: Truth, result: object) -> list[Part]:
    """Return how far angles, matrices and rows are off in the worst photo."""
    found, M = named(result, WANTED), truth.M(truth.drone)
    # Two matrices a small angle apart differ by the root of 2 times it, and the three
    # roundings together turn by the root of 3 times one
    off = [
        np.linalg.norm(one - M, axis=(1, 2)) / (np.sqrt(6) * SD)
        for one in (_built(found["angles"]), found["M"])
    ]
    off.append(np.abs(found["row"] - truth.row(M)) / truth.sd)
    return [Part(name, float(np.max(one))) for name, one in zip(WANTED, off)]


def slips(truth: Truth) -> dict[str, dict]:
    """Return what the likeliest wrong programs give."""
    drone, mount = truth.written, _mounted(truth.side, truth.below)
    right = truth.M(drone)
    signs = dict(zip(("yaw", "pitch", "roll"), drone * (1 - 2 * np.eye(3))[:, None]))
    other = {
        "Yaw, pitch and roll count from north, east and down, M from east, north"
        " and up. One more matrix stands between the two.": mount @ _turned(drone),
        "Yaw turns from north to east, about an axis that points down.": (
            truth.M(signs["yaw"])
        ),
        "A positive pitch lifts the nose of the drone.": truth.M(signs["pitch"]),
        "A positive roll lowers its right side.": truth.M(signs["roll"]),
        "The order: the drone makes yaw first, and the turn made first stands on the"
        " right.": mount @ _turned(drone, "first on the left") @ DOWN,
        "The file is in degrees; sine and cosine take radians.": (
            truth.M(np.degrees(drone))
        ),
        "The camera looks below the plane of the drone's x and y axes, not above it.": (
            _mounted(truth.side, -truth.below) @ _turned(drone) @ DOWN
        ),
        "To which side does the camera look? The drone's y axis points to its right.": (
            _mounted(-truth.side, truth.below) @ _turned(drone) @ DOWN
        ),
        "The camera looks along its minus z axis, and its y axis points up.": (
            np.diag([1, -1, -1]) @ right
        ),
        "The photo stands on its head: its y axis points up.": (
            np.diag([-1, -1, 1]) @ right
        ),
        "The direction: M leads from object space to the image.": right.swapaxes(1, 2),
    }
    answers = {words: _answer(truth, M) for words, M in other.items()}
    good = _answer(truth, right)
    wrong_rows = {
        "Rows are counted downwards, and y points up.": SIZE[1] - 1 - good["row"],
        "Row 0 is the middle of the first pixel: half a pixel.": good["row"] + 0.5,
        "The camera is rotated about its line of sight, too, so that the horizon is not"
        " level in the photo.": _rows(truth.c * np.tan(np.arcsin(right[:, 2, 2]))),
    }
    degrees = "The angles are wanted in degrees."
    answers[degrees] = good | {"angles": np.radians(good["angles"])}
    return answers | {words: good | {"row": r} for words, r in wrong_rows.items()}


def hint(truth: Truth, result: object) -> str:
    """Return the hint to the slip that explains the first wrong part, M before all."""
    found, good = named(result, WANTED), _answer(truth, truth.M(truth.written))

    def first_wrong(answer: dict) -> str:
        parts = "M", "angles"
        return next((p for p in parts if not near(answer[p], good[p], 1e-4)), "row")

    part = first_wrong(found)
    for words, wrong in slips(truth).items():
        if first_wrong(wrong) == part and near(found[part], wrong[part], 1e-4):
            return words
    if part == "row" and near(found[part], good[part].round(), 1e-4):
        return "These are whole pixels: a row is wanted with its fraction."
    return {
        "M": "Write M as three factors, and test each by the vectors that it must turn"
        " into x, y or z: north-east-down, drone, camera.",
        "angles": "M is right. Read the angles out of it, each in its quadrant.",
        "row": "M is right. Of the rays (0, y, -c), which one has no height?",
    }[part]


def picture(truth: Truth, result: object) -> tuple[Figure, str]:
    """Draw three of the photos as your angles take them, and the horizon you found."""
    found, true = named(result, WANTED), truth.row(truth.M(truth.drone))
    fig, axes = plt.subplots(1, 3, figsize=(10, 3.3), layout="constrained")
    form = SIZE[0] * PIXEL / truth.c, SIZE[1] * PIXEL / truth.c
    for k, ax in enumerate(axes):
        exterior = np.array([0, -30, 20, *np.radians(found["angles"][k])])
        space.draw_photo(
            ax, exterior, figures.surroundings(), form=form, ground=figures.GROUND
        )
        for text in list(ax.texts):
            text.remove()  # the circle would hide them
        y = (SIZE[1] / 2 - 0.5 - found["row"][k]) * PIXEL / truth.c
        ax.axvline(0, color="0.4", lw=1, ls="--")
        ax.plot(0, y, "o", ms=11, mfc="none", mec=plot.RED, mew=2.5)
        said = f"photo {k + 1}: row {found['row'][k]:.1f}"
        ax.set_title(f"{said}\n(true: {true[k]:.1f})", loc="center", fontsize=15)
    return fig, (
        "Three photos of a wide plain as cameras with your angles see it: sky above a"
        " slanting horizon. In each a red circle marks your row on the dashed middle"
        " column; it lies on the horizon. Your rows and the true ones agree to parts of"
        " a pixel."
    )


def _turned(drone: np.ndarray, order: str = "") -> np.ndarray:
    """From north, east, down to the drone: yaw, then pitch, then roll (6, 3, 3)."""
    nothing = np.zeros(len(drone))
    turns = [
        rotation.matrix(drone[:, 2], nothing, nothing),
        rotation.matrix(nothing, drone[:, 1], nothing),
        rotation.matrix(nothing, nothing, drone[:, 0]),
    ]
    roll, pitch, yaw = turns[::-1] if order else turns
    return roll @ pitch @ yaw


def _mounted(side: float, below: float) -> np.ndarray:
    """From the drone to the camera: its right, its top, and away from what it sees."""
    s, c = np.sin(below), np.cos(below)
    return np.array([[0, 1, 0], [s, 0, -c], [-c, 0, -s]]) @ rotation.matrix(0, 0, side)


def _rows(y: np.ndarray) -> np.ndarray:
    """Rows of points (0, y) of a photo."""
    photo = np.column_stack([0 * y, y])
    return frames.photo_to_pixel(photo, SIZE, PIXEL)[:, 1]


def _answer(truth: Truth, M: np.ndarray) -> dict[str, np.ndarray]:
    """Return all that is asked, with these matrices."""
    return {"angles": np.degrees(rotation.angles(M)), "M": M, "row": truth.row(M)}


def _built(degrees: np.ndarray) -> np.ndarray:
    return rotation.matrix(*np.radians(degrees).T)
