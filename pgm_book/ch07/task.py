"""The task of chapter 7: how two satellite images lie, and what changed in between."""

from dataclasses import dataclass

import matplotlib.pyplot as plt
import numpy as np
import scipy.ndimage
from matplotlib.figure import Figure

from pgm_book.common.checks import CheckFailed
from pgm_book.common.figures import outline
from pgm_book.task import Part, grey, named, table
from pgm_lab import datasets, plot, registration
from pgm_lab.image import cut
from pgm_lab.plot.basic import Look

SIZE, FINER = 320, 2  # px of each image; pixels of the scene in one of them
CENTRE = (SIZE - 1) / 2
NOISE = 1.5  # grey levels, of each image
MARGIN = 60  # pixels of the scene around the reference
MIXED = 0.3  # share of new ground in the changed field
FIELDS, FIELD = 8, 41  # how many, and px across each
# Standard deviations of an honest solution, found from those of 40 names; which points
# can be measured moves RMSE and CE90 more than noise does
SD = {
    "dx": 0.016,
    "dy": 0.016,
    "scale": 0.00012,
    "turn": 0.0085,
    "rmse": 0.1 / 3,
    "ce90": 0.3 / 3,
}
WANTED = {
    "dx": ("one number in px", ()),
    "dy": ("one number in px", ()),
    "scale": ("one number as a ratio", ()),
    "turn": ("one number in degrees", ()),
    "rmse": ("one number in px", ()),
    "ce90": ("one number in px", ()),
    "field": ("its row in the file", ()),
}

SIGN = "dx, dy: a shift is sensed minus reference."
EXCHANGED = "dx is along the columns, dy along the rows."
ORIGIN = "dx, dy: the shift is wanted at the centre of the image, not at pixel (0, 0)."
SCALE = (
    "scale: is a length in the sensed image larger or smaller than in the reference?"
)
NO_SCALE = "scale: 1 where lengths are equal, and not their difference from 1."
RADIANS = "turn: degrees are wanted."
SENSE = "turn: clockwise is positive, and rows are counted downwards."
RESIDUAL = "rmse: of the shifts as they are, before anything was corrected."
FACTOR = "ce90: nine of ten distances are below it. No normal distribution is needed."
BLUNDERS = (
    "Points under the cloud or on changed ground do not count: their shifts are far"
    " from what the others say."
)
LEFT_OUT = (
    "Good points were left out, those with the longest shifts: a scale or a turn makes"
    " good shifts differ. Compare each shift with the model, not with the median."
)
CHANGED = (
    "field: fetch the sensed image to the reference first, then compare each field."
)


@dataclass(frozen=True)
class Truth:
    """How the sensed image lies, what changed, and which points can be measured."""

    shift: np.ndarray  # px, at the centre
    scale: float
    turn: float  # radians, clockwise
    points: np.ndarray  # (n, 2), those that can be measured
    field: int  # its row in the file, from 0
    reference: np.ndarray
    fields: np.ndarray  # (8, 2): column, row of the centre of each

    def shifts(self, points: np.ndarray) -> np.ndarray:
        """Shifts of points (n, 2) of the reference, sensed minus reference."""
        return _shifts(points, self.shift, self.scale, self.turn)

    @property
    def values(self) -> dict[str, float]:
        """The numbers that are asked for."""
        shifts = self.shifts(self.points)
        lies = *self.shift, self.scale, np.degrees(self.turn)
        ce90 = np.quantile(np.hypot(*shifts.T), 0.9)
        return dict(zip(SD, (*lies, _rms(shifts), ce90)))


def make(
    chance: np.random.RandomState,
) -> tuple[dict[str, str | np.ndarray], Truth]:
    """Cut two images out of the Landsat scene; cloud and field are put into one."""
    shift = chance.choice([-1, 1], 2) * np.round(chance.uniform(1.2, 3, 2), 2)
    scale = 1 + chance.choice([-1, 1]) * np.round(chance.uniform(0.006, 0.011), 4)
    turn = np.radians(chance.choice([-1, 1]) * np.round(chance.uniform(0.3, 0.6), 2))
    left, top = chance.randint(MARGIN, 1200 - FINER * SIZE - MARGIN, 2) - MARGIN
    wide = FINER * SIZE + 2 * MARGIN
    scene = datasets.landsat().grey[top : top + wide, left : left + wide].astype(float)
    scene = np.clip((scene - 5900) / (9300 - 5900), 0, 1) * 200 + 20
    scene = scipy.ndimage.gaussian_filter(scene, 1.2 * FINER)
    row, column = np.indices((SIZE, SIZE))
    pixels = np.stack([column.ravel(), row.ravel()], axis=1)

    def taken(at: np.ndarray) -> np.ndarray:
        places = MARGIN + FINER * at.T[::-1]
        return scipy.ndimage.map_coordinates(scene, places, order=3).reshape(SIZE, SIZE)

    # A pixel of the sensed image shows the ground of this place of the reference
    back = (pixels - CENTRE - shift) @ np.array(
        [(np.cos(turn), -np.sin(turn)), (np.sin(turn), np.cos(turn))]
    ) / scale + CENTRE
    reference, sensed = taken(pixels), taken(back)
    x, y = np.meshgrid(np.arange(5) * 55 + 50, np.arange(5) * 55 + 50)
    places = np.column_stack([x.ravel(), y.ravel()])
    # Where shifts are longest, so that RMSE and CE90 without these points are others
    cloud = places[np.hypot(*_shifts(places, shift, scale, turn).T).argmax()]
    radius = chance.uniform(40, 46)
    texture = np.array([cut(reference, place, FIELD).std() for place in places])
    far = np.hypot(*(places - cloud).T) > radius + 30
    fields = places[np.sort(np.argsort(-np.where(far, texture, -1))[:FIELDS])]
    # The field that fits best before the warp, so that nothing shows it but the warp
    field = int(np.argmax([_r(reference, sensed, one) for one in fields]))
    changed = fields[field]
    # New ground of the same mean and contrast shines through, without a sharp border
    within = np.clip((28 - np.abs(back - changed).max(axis=1)) / 8, 0, 1)
    within = within.reshape(SIZE, SIZE)
    was, new = sensed[within > 0], taken(back[:, ::-1])[within > 0]
    new = was.mean() + (new - new.mean()) * was.std() / new.std()
    sensed[within > 0] += MIXED * within[within > 0] * (new - was)
    sensed = sensed * chance.uniform(0.75, 0.95) + chance.uniform(5, 25)
    away = np.hypot(*(back - cloud).T).reshape(SIZE, SIZE)
    sensed += np.clip((radius - away) / 8, 0, 1) * (235 - sensed)
    # One point in each square of 31 by 31 pixels
    x, y = np.meshgrid(np.arange(9) * 31 + 36, np.arange(9) * 31 + 36)
    points = np.column_stack([x.ravel(), y.ravel()]) + chance.randint(-10, 11, (81, 2))
    reference, sensed = (
        grey(one + NOISE * chance.standard_normal(one.shape))
        for one in (reference, sensed)
    )
    true = _shifts(points, shift, scale, turn)
    found = registration.register(
        reference, sensed, points, 21, 9, "parabola", threshold=-1, ratio=1
    )
    free = np.hypot(found.dx - true[:, 0], found.dy - true[:, 1]) < 0.3  # measurable
    truth = Truth(shift, scale, turn, points[free], field, reference, fields)
    some, ce90 = truth.values["rmse"], truth.values["ce90"]
    alike = abs(_rms(true) - some) < 3.3 * SD["rmse"]  # it would not matter which count
    alike = bool(alike or np.ptp(shift) < 0.1)  # nor which of the two is dx
    if alike or abs(1.5175 * some - ce90) < 3.3 * SD["ce90"]:
        return make(chance)
    return {
        "reference.png": reference,
        "sensed.png": sensed,
        "points.csv": table("column,row", "{},{}", points),
        "fields.csv": table("column,row", "{},{}", fields),
    }, truth


def _shifts(
    points: np.ndarray, shift: np.ndarray, scale: float, turn: float
) -> np.ndarray:
    """Shifts of points (n, 2) of the reference, sensed minus reference."""
    c, s = scale * np.cos(turn), scale * np.sin(turn)
    return shift + (points - CENTRE) @ (np.array([(c, s), (-s, c)]) - np.eye(2))


def _rms(shifts: np.ndarray) -> float:
    return np.sqrt(np.mean(np.sum(shifts**2, axis=1)))


def _r(a: np.ndarray, b: np.ndarray, field: np.ndarray) -> float:
    """Correlation of two images in the same window."""
    return np.corrcoef(cut(a, field, FIELD).flat, cut(b, field, FIELD).flat)[0, 1]


def judge(truth: Truth, result: object) -> list[Part]:
    """Return how far each value is off, and whether the field is right."""
    found, known = _answer(result), truth.values
    parts = [
        Part(n, abs(found[n] - known[n]), 3 * sd, "px")
        if n in ("rmse", "ce90")
        else Part(n, abs(found[n] - known[n]) / sd)
        for n, sd in SD.items()
    ]
    return [*parts, Part("the field", float(found["field"] != truth.field), 0)]


def _answer(result: object) -> dict[str, float]:
    """Return the numbers by name; or say what is wanted."""
    found = named(result, WANTED)
    if found["field"] not in range(FIELDS):
        raise CheckFailed(f"field must be a row of the file, from 0 to {FIELDS - 1}")
    return found


def slips(truth: Truth) -> dict[str, dict[str, float]]:
    """Return what the likeliest wrong programs give."""
    known = truth.values
    right = known | {"field": truth.field}
    dx, dy = truth.shift
    corner = truth.shifts(np.zeros((1, 2)))[0]
    changes: dict[str, dict[str, float]] = {
        SIGN: {"dx": -dx, "dy": -dy},
        EXCHANGED: {"dx": dy, "dy": dx},
        ORIGIN: {"dx": corner[0], "dy": corner[1]},
        SCALE: {"scale": 1 / known["scale"]},
        NO_SCALE: {"scale": known["scale"] - 1},
        SENSE: {"turn": -known["turn"]},
        RADIANS: {"turn": truth.turn},
        RESIDUAL: {"rmse": 0.1},
        FACTOR: {"ce90": 1.5175 * known["rmse"]},
        BLUNDERS: {"rmse": known["rmse"] + 0.5, "ce90": known["ce90"] + 1},
        LEFT_OUT: {"rmse": known["rmse"] - 0.3, "ce90": known["ce90"] - 0.6},
        CHANGED: {"field": (truth.field + 1) % FIELDS},
    }
    return {words: right | change for words, change in changes.items()}


def hint(truth: Truth, result: object) -> str:
    """Return the hint to the first value that is wrong."""
    found, known = _answer(result), truth.values
    wrong = [n for n, sd in SD.items() if not abs(found[n] - known[n]) <= 3 * sd]
    if not wrong:
        return CHANGED
    for words, slip in slips(truth).items():
        if all(abs(found[n] - slip[n]) <= 3 * SD[n] for n in wrong):
            return words
    for name in ("ce90", "rmse"):
        if name in wrong:
            return BLUNDERS if found[name] > known[name] else LEFT_OUT
    return (
        f"{wrong[0]}: which points count? Search far enough, compare each shift with"
        " the model, not with the median; leave out what is off, and adjust again."
    )


def picture(truth: Truth, result: object) -> tuple[Figure, str]:
    """Draw the reference with its fields, and the true shifts of its points."""
    field = int(_answer(result)["field"])
    fig, ax = plt.subplots(figsize=(6.5, 6.5), layout="constrained")
    ax.imshow(truth.reference // 16, cmap="gray", interpolation="nearest")
    for number, (x, y) in enumerate(truth.fields):
        colour = plot.RED if number == field else plot.SKY
        outline(ax, (x, y), FIELD, colour, linewidth=2.5)
        ax.text(x - 17, y - 6, str(number), color=colour, fontsize=15, weight="bold")
    x, y = truth.points.T
    arrows: Look = {"angles": "xy", "scale_units": "xy", "scale": 0.2}
    ax.quiver(x, y, *truth.shifts(truth.points).T, color=plot.YELLOW, **arrows)
    ax.set(title="shifts, five times as long", xlabel="column (px)", ylabel="row (px)")
    ax.grid(False)
    return fig, (
        f"The reference image with eight fields, field {field} in another colour, and"
        f" the true shifts of {len(x)} points as arrows, five times as long."
    )
