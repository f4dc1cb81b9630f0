"""The task of chapter 4: from a drone's yaw, pitch and roll to the book's angles."""

from dataclasses import dataclass, replace
from functools import cached_property, partial

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from pgm_book.ch04 import figures
from pgm_book.program.camera import derivatives
from pgm_book.task import Answer, Part, likeliest, named, table
from pgm_lab import frames, plot, rotation
from pgm_lab.plot import space

SIZE, PIXEL, PHOTOS = (4000, 3000), 0.004, 6  # the camera, pixels in mm; and how many
SD = np.radians(0.01) / np.sqrt(12)  # of an angle that is rounded to 0.01 degrees
DOWN = figures.NORTH_EAST_DOWN
WANTED = {
    "angles": ("omega, phi, kappa in degrees, one row a photo", (PHOTOS, 3)),
    "M": ("one M (3, 3) a photo", (PHOTOS, 3, 3)),
    "row": ("the row of the horizon in each photo", (PHOTOS,)),
}
read = partial(named, wanted=WANTED)


@dataclass(frozen=True)
class Truth:
    """The right answer, the drone, and how its camera is fixed to it; radians."""

    answer: Answer
    drone: np.ndarray  # (6, 3): yaw, pitch, roll, with all digits
    written: np.ndarray  # the same, as the autopilot rounds it
    mount: np.ndarray  # (3, 3), from the drone to the camera
    c: float  # mm

    def M(self, drone: np.ndarray) -> np.ndarray:
        """Rotation matrices (6, 3, 3) of the camera."""
        return self.mount @ _turned(drone) @ DOWN

    @cached_property
    def sd(self) -> np.ndarray:
        """Standard deviations (6,) of the rows in pixels, from the rounded angles."""

        def rows(drone: np.ndarray) -> np.ndarray:
            return _row(self.c, self.M(drone.reshape(-1, 3)))

        return SD * np.linalg.norm(derivatives(rows, self.drone.ravel()), axis=1)


def make(chance: np.random.RandomState) -> tuple[dict[str, str], Truth]:
    """Six photos of a drone that flies along a coast and looks to one side."""
    side = np.radians(chance.choice([-1, 1]) * chance.uniform(50, 80))  # left or right
    below = np.radians(chance.uniform(10, 20))
    c = round(chance.uniform(8.5, 9.5), 2)
    yaw = chance.uniform(0, 360, PHOTOS)
    pitch, roll = chance.uniform(2, 8, (2, PHOTOS)) * chance.choice([-1, 1], (2, 6))
    drone = np.column_stack([yaw, pitch, roll])
    written = np.round(drone, 2)
    # The camera's right, its top, and away from what it sees
    s, k = np.sin(below), np.cos(below)
    ahead = np.array([[0, 1, 0], [s, 0, -k], [-k, 0, -s]])
    mount = np.round(ahead @ rotation.matrix(0, 0, side), 9)
    head, rows = "photo,yaw_deg,pitch_deg,roll_deg", enumerate(written, 1)
    flight = table(head, "{}" + 3 * ",{:.2f}", ((n, *one) for n, one in rows))
    axes = table("forward,right,down", "{:.9f},{:.9f},{:.9f}", mount + 0.0)
    camera = table("c_mm,columns,rows,pixel_mm", "{:.2f},{},{},{}", [(c, *SIZE, PIXEL)])
    files = {"attitude.csv": flight, "mount.csv": axes, "camera.csv": camera}
    truth = Truth({}, np.radians(drone), np.radians(written), mount, c)
    return files, replace(truth, answer=_asked(c, truth.M(truth.drone)))


def judge(truth: Truth, found: Answer) -> list[Part]:
    """Return how far angles, matrices and rows are off in the worst photo."""
    right = truth.answer
    built, M = (rotation.matrix(*np.radians(one["angles"]).T) for one in (found, right))
    # Two matrices a small angle apart differ by the root of 2 times it, and the three
    # roundings together turn by the root of 3 times one
    off = [
        np.linalg.norm(one, axis=(1, 2)) / (np.sqrt(6) * SD)
        for one in (built - M, found["M"] - right["M"])
    ]
    off.append(np.abs(found["row"] - right["row"]) / truth.sd)
    return [Part(name, float(np.max(one))) for name, one in zip(WANTED, off)]


def slips(truth: Truth) -> dict[str, Answer]:
    """Return what the likeliest wrong programs give."""
    drone, mount, asked = truth.written, truth.mount, partial(_asked, truth.c)
    angles, M, row = asked(truth.M(drone)).values()
    return {
        "Yaw, pitch and roll count from north, east and down, M from east, north"
        " and up. One more matrix stands between the two.": (
            asked(mount @ _turned(drone))
        ),
        "Yaw turns from north to east, about an axis that points down.": (
            asked(truth.M(drone * (-1, 1, 1)))
        ),
        "The order: the drone makes yaw first, and the turn made first stands on the"
        " right.": asked(mount @ _turned(drone, "first on the left") @ DOWN),
        "`flight` is in radians already.": asked(truth.M(np.radians(drone))),
        "The rows of mount.csv are new axes in the old frame: from where to where does"
        " such a matrix lead?": asked(mount.T @ _turned(drone) @ DOWN),
        "mount.csv leads on from the drone to the camera, and is still missing.": (
            asked(_turned(drone) @ DOWN)
        ),
        "The direction: M leads from object space to the image.": (
            asked(M.swapaxes(1, 2))
        ),
        "The angles are wanted in degrees.": {"angles": np.radians(angles)},
        "The order of the angles is omega, phi, kappa.": {"angles": angles[:, ::-1]},
        "Rows are counted downwards, and y points up.": {"row": SIZE[1] - 1 - row},
        "Row 0 is the middle of the first pixel: half a pixel.": {"row": row + 0.5},
        "Rows are counted from 0.": {"row": row + 1},
        "The transpose of M leads a ray of the photo into object space.": {
            "row": _at(truth.c * M[:, 2, 2] / M[:, 2, 1])
        },
        "The camera is rotated about its line of sight, too, so that the horizon is not"
        " level in the photo.": {"row": _at(truth.c * np.tan(np.arcsin(M[:, 2, 2])))},
    }


def hint(truth: Truth, found: Answer, wrong: list[str]) -> str:
    """Return the hint to the slip that explains the first wrong part."""
    part, M_holds = wrong[0], "M" not in wrong
    known = slips(truth).items()
    blameless = {words: one for words, one in known if not (M_holds and "M" in one)}
    if slip := likeliest(judge, truth, found, [part], blameless):
        return slip
    asked, right = found[part], _asked(truth.c, truth.M(truth.written))[part]
    if np.allclose(asked, right, rtol=0, atol=0.6) and part != "M":
        return "That is right but for its last digits: was something rounded?"
    if part == "angles" and np.allclose((asked - right + 1) % 180, 1, rtol=0):
        return "An angle is half a turn off: a quotient loses the signs of its parts."
    if part == "angles" and M_holds:
        return "M is right; the angles read from it are not: signs, or the quadrant?"
    return {
        "M": "The angles are right; M is what you read them from.",
        "angles": "Write M as a product, and test each factor by the vectors that it"
        " must turn into x, y or z: north-east-down, drone, camera.",
        "row": "The angles are right. Of the rays (0, y, -c), which one has no height?",
    }[part]


def picture(truth: Truth, found: Answer) -> tuple[Figure, str]:
    """Draw three of the photos as your angles take them, and the horizon you found."""
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
        ax.set_title(
            f"{said}\n(true: {truth.answer['row'][k]:.1f})", loc="center", fontsize=15
        )
    return fig, (
        "Three photos of a wide plain as cameras with your angles see it: sky above a"
        " slanting horizon. In each a red circle marks your row on the dashed middle"
        " column; it lies on the horizon. Your rows and the true ones agree to parts of"
        " a pixel."
    )


def _turned(drone: np.ndarray, order: str = "") -> np.ndarray:
    """From north, east, down to the drone: yaw, then pitch, then roll (6, 3, 3)."""
    turns = [
        rotation.matrix(*(drone[:, k] * np.eye(3)[2 - k][:, None])) for k in range(3)
    ]
    yaw, pitch, roll = turns[::-1] if order else turns
    return roll @ pitch @ yaw


def _asked(c: float, M: np.ndarray) -> Answer:
    """Return all that is asked, with these matrices (6, 3, 3)."""
    return {"angles": np.degrees(rotation.angles(M)), "M": M, "row": _row(c, M)}


def _row(c: float, M: np.ndarray) -> np.ndarray:
    """Rows where the horizon crosses the middle column: (0, y, -c) is level."""
    return _at(c * M[:, 2, 2] / M[:, 1, 2])


def _at(y: np.ndarray) -> np.ndarray:
    """Rows of points (0, y) of a photo."""
    return frames.photo_to_pixel(np.column_stack([0 * y, y]), SIZE, PIXEL)[:, 1]
