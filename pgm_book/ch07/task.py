"""The task of chapter 7: how two satellite images lie, and what changed in between."""

from dataclasses import dataclass
from functools import cache

import matplotlib.pyplot as plt
import numpy as np
import scipy.ndimage
from matplotlib.figure import Figure

from pgm_book.common.checks import CheckFailed
from pgm_book.common.figures import outline
from pgm_book.program.registration import correlation
from pgm_book.task import Answer, Part, grey, likeliest, named, table
from pgm_lab import datasets, plot, registration
from pgm_lab.image import cut
from pgm_lab.plot.basic import Look

SIZE, FINER = 320, 2  # px of each image; pixels of the scene in one of them
CENTRE = (SIZE - 1) / 2
NOISE = 1.5  # grey levels, of each image
MARGIN = 60  # pixels of the scene around the reference
MIXED = 0.3  # share of new ground in the changed field
FIELDS, FIELD = 8, 41  # how many, and px across each
# Of a good program, from those of 40 names; scale is a ratio, turn in degrees
SD = {
    "dx": 0.017,
    "dy": 0.017,
    "scale": 0.0002,
    "turn": 0.013,
    "rmse": 0.04,
    "ce90": 0.09,
}
WANTED = {name: ("one number", ()) for name in SD}
WANTED["field"] = ("its row in the file", ())

FACTOR = "ce90: nine of ten distances are below it. No normal distribution is needed."
BLUNDERS = (
    "Points under the cloud or on changed ground do not count: their shifts are far"
    " from what the others say."
)
LEFT_OUT = (
    "Good points were left out, those with the longest shifts: search far enough, and"
    " compare each shift with the model, not with the median."
)
CHANGED = (
    "field: fetch the sensed image to the reference first; where something new grows, r"
    " is lowest. The rows of the file count from 0."
)


@dataclass(frozen=True)
class Truth:
    """How the sensed image lies, what changed, and which points can be measured."""

    answer: Answer
    corner: np.ndarray  # px, the shift of pixel (0, 0)
    points: np.ndarray  # (n, 2), those that can be measured
    shifts: np.ndarray  # (n, 2), px, of these points
    reference: np.ndarray
    fields: np.ndarray  # (8, 2): column, row of the centre of each


def make(chance: np.random.RandomState) -> tuple[dict, Truth]:
    """Cut two images out of the Landsat scene; cloud and field are put into one."""
    shift = chance.permutation(np.round(chance.uniform((3.6, 0.5), (4, 1.5)), 2))
    shift *= chance.choice([-1, 1], 2)
    scale = 1 + chance.choice([-1, 1]) * np.round(chance.uniform(0.006, 0.011), 4)
    turn = np.radians(chance.choice([-1, 1]) * np.round(chance.uniform(0.3, 0.6), 2))
    c, s = scale * np.cos(turn), scale * np.sin(turn)
    turned = np.array([(c, s), (-s, c)])
    left, top = chance.randint(MARGIN, 1200 - FINER * SIZE - MARGIN, 2) - MARGIN
    wide = FINER * SIZE + 2 * MARGIN
    scene = _landsat()[top : top + wide, left : left + wide].astype(float)
    scene = np.clip((scene - 5900) / (9300 - 5900), 0, 1) * 200 + 20
    spline = scipy.ndimage.spline_filter(
        scipy.ndimage.gaussian_filter(scene, 1.2 * FINER), mode="mirror"
    )

    def taken(at: np.ndarray) -> np.ndarray:
        places = MARGIN + FINER * at.T[::-1]
        values = scipy.ndimage.map_coordinates(spline, places, order=3, prefilter=False)
        return values.reshape(SIZE, SIZE)

    def shifts(at: np.ndarray) -> np.ndarray:
        return shift + (at - CENTRE) @ (turned - np.eye(2))

    # A pixel of the sensed image shows the ground of this place of the reference
    pixels = _grid(SIZE)
    back = (pixels - CENTRE - shift) @ np.linalg.inv(turned) + CENTRE
    reference, sensed = taken(pixels), taken(back)
    places = 50 + 55 * _grid(5)
    # Where shifts are shortest: too short a search loses others, and it shows
    cloud = places[np.hypot(*shifts(places).T).argmin()]
    radius = chance.uniform(70, 76)
    texture = np.array([cut(reference, place, FIELD).std() for place in places])
    far = np.hypot(*(places - cloud).T) > radius + 30
    fields = places[np.sort(np.argsort(-np.where(far, texture, -1))[:FIELDS])]
    # The field that fits best before the warp, so that nothing shows it but the warp
    both = [[cut(one, place, FIELD) for one in (reference, sensed)] for place in fields]
    field = int(np.argmax([correlation(*two) for two in both]))
    # New ground of the same mean and contrast shines through, without a sharp border
    within = np.clip((28 - np.abs(back - fields[field]).max(axis=1)) / 8, 0, 1)
    within = within.reshape(SIZE, SIZE)
    was, new = sensed[within > 0], taken(back[:, ::-1])[within > 0]
    new = was.mean() + (new - new.mean()) * was.std() / new.std()
    sensed[within > 0] += MIXED * within[within > 0] * (new - was)
    sensed = sensed * chance.uniform(0.75, 0.95) + chance.uniform(5, 25)
    away = np.hypot(*(back - cloud).T).reshape(SIZE, SIZE)
    sensed += np.clip((radius - away) / 8, 0, 1) * (235 - sensed)
    # One point in each square of 31 by 31 pixels
    points = 36 + 31 * _grid(9) + chance.randint(-10, 11, (81, 2))
    reference, sensed = (
        grey(one + NOISE * chance.standard_normal(one.shape))
        for one in (reference, sensed)
    )
    found = registration.register(
        reference, sensed, points, 21, 9, "parabola", threshold=-1, ratio=1
    )
    true, at = shifts(points), np.column_stack([found.dx, found.dy])
    free = np.hypot(*(at - true).T) < 0.3  # measurable
    every = at[np.abs(at).max(axis=1) < 8.5]  # with blunders
    near = true[free & (np.abs(true).max(axis=1) < 4.5)]  # by a search of 5 pixels
    size = _size(true[free])
    # It must matter which points count
    apart = np.abs([_size(some) - size for some in (every, near)])
    if free.sum() < 60 or np.any(apart < 4 * np.array((SD["rmse"], SD["ce90"]))):
        return make(chance)
    answer = dict(zip(WANTED, (*shift, scale, np.degrees(turn), *size, field)))
    return {
        "reference.png": reference,
        "sensed.png": sensed,
        "points.csv": table("column,row", "{},{}", points),
        "fields.csv": table("column,row", "{},{}", fields),
    }, Truth(answer, shifts(np.zeros(2)), points[free], true[free], reference, fields)


@cache
def _landsat() -> np.ndarray:
    """Grey values of the scene, read once however often a task is drawn."""
    return datasets.landsat().grey


def _grid(n: int) -> np.ndarray:
    """Column and row (n², 2) of each pixel of a square, row by row."""
    return np.indices((n, n))[::-1].reshape(2, -1).T


def _size(shifts: np.ndarray) -> np.ndarray:
    """RMSE_T and CE90 of shifts (n, 2)."""
    far = np.hypot(*shifts.T)
    return np.array([np.sqrt(np.mean(far**2)), np.quantile(far, 0.9)])


def judge(truth: Truth, found: Answer) -> list[Part]:
    """Return how far each value is off, and whether the field is right."""
    right = truth.answer
    parts = [Part(name, abs(found[name] - right[name]) / SD[name]) for name in SD]
    return [*parts, Part("field", float(found["field"] != right["field"]), 0)]


def read(result: object) -> Answer:
    """Return the numbers by name; or say what is wanted."""
    found = named(result, WANTED)
    if found["field"] not in range(FIELDS):
        raise CheckFailed(f"field must be a row of the file, from 0 to {FIELDS - 1}")
    return found


def slips(truth: Truth) -> dict[str, Answer]:
    """Return what the likeliest wrong programs give."""
    dx, dy, scale, turn, rmse, ce90, field = truth.answer.values()
    return {
        "dx, dy: a shift is sensed minus reference.": {"dx": -dx, "dy": -dy},
        "dx is along the columns, dy along the rows.": {"dx": dy, "dy": dx},
        "dx, dy: at the centre of the image, not at pixel (0, 0).": dict(
            zip(("dx", "dy"), truth.corner)
        ),
        "scale: is a length in the sensed image larger or smaller than in the"
        " reference?": {"scale": 1 / scale},
        "scale: 1 where lengths are equal, and not their difference from 1.": {
            "scale": scale - 1
        },
        "turn: clockwise is positive, and rows are counted downwards.": {"turn": -turn},
        "turn: degrees are wanted.": {"turn": np.radians(turn)},
        "rmse: of the shifts as they are, before anything was corrected.": {
            "rmse": 0.1
        },
        "rmse: nothing is subtracted, not even the mean.": {
            "rmse": np.hypot(*truth.shifts.std(axis=0))
        },
        "rmse: of both directions, not of one.": {
            "rmse": np.sqrt(np.mean(truth.shifts[:, 0] ** 2))
        },
        BLUNDERS: {"rmse": rmse + 0.5, "ce90": ce90 + 1},
        LEFT_OUT: {"rmse": rmse - 0.3, "ce90": ce90 - 0.6},
        FACTOR: {"ce90": 1.5175 * rmse},
        CHANGED: {"field": (field + 1) % FIELDS},
    }


def hint(truth: Truth, found: Answer, wrong: list[str]) -> str:
    """Return the hint to the slip that explains a wrong value, or to the first one."""
    if words := likeliest(judge, truth, found, wrong, slips(truth)):
        return words
    if "rmse" in wrong:
        return BLUNDERS if found["rmse"] > truth.answer["rmse"] else LEFT_OUT
    if words := {"ce90": FACTOR, "field": CHANGED}.get(wrong[0], ""):
        return words
    return (
        f"{wrong[0]}: which points count? Search far enough, compare each shift with"
        " the model, not with the median; leave out what is off, and adjust again."
    )


def picture(truth: Truth, found: Answer) -> tuple[Figure, str]:
    """Draw the reference with its fields, and the true shifts of its points."""
    field = int(found["field"])
    fig, ax = plt.subplots(figsize=(6.5, 6.5), layout="constrained")
    ax.imshow(truth.reference // 16, cmap="gray", interpolation="nearest")
    for number, (x, y) in enumerate(truth.fields):
        colour = plot.RED if number == field else plot.SKY
        outline(ax, (x, y), FIELD, colour, linewidth=2.5)
        ax.text(x - 17, y - 6, str(number), color=colour, fontsize=15, weight="bold")
    arrows: Look = {"angles": "xy", "scale_units": "xy", "scale": 0.2}
    ax.quiver(*truth.points.T, *truth.shifts.T, color=plot.YELLOW, **arrows)
    ax.set(title="shifts, five times as long", xlabel="column (px)", ylabel="row (px)")
    ax.grid(False)
    return fig, (
        f"The reference image with eight fields, field {field} in another colour, and"
        f" the true shifts of {len(truth.points)} points as arrows, five times as long."
    )
