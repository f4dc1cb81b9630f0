"""The task of chapter 7: how two satellite images lie, and what changed in between."""

from dataclasses import dataclass
from functools import cache

import cv2
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
NOISE = 0.7  # grey levels, of each image
CLOUD = 73  # px, radius
MARGIN = 60  # pixels of the scene around the reference
MIXED = 0.3  # share of new ground in the changed field
FIELDS, FIELD = 8, 41  # how many, and px across each
SLID = 1.8  # px, by which a piece of ground has slid
# Of a good program, from those of 40 names; scale is a ratio, turn in degrees
SD = dict(dx=0.017, dy=0.017, scale=0.0002, turn=0.013, rmse=0.05, ce90=0.065)
WANTED = {name: ("one number", ()) for name in SD}
WANTED["field"] = ("its row in the file", ())


@dataclass(frozen=True)
class Truth:
    """How the sensed image lies, what changed, and what a search finds."""

    answer: Answer
    corner: Answer  # dx, dy of pixel (0, 0)
    points: np.ndarray  # (81, 2)
    shifts: np.ndarray  # (81, 2), px, had no ground slid
    found: np.ndarray  # (81, 2), px, by a search
    r: np.ndarray  # (81,), of these
    free: np.ndarray  # (81,), which can be measured, and have not slid
    reference: np.ndarray
    fields: np.ndarray  # (8, 2): column, row of the centre of each


def make(chance: np.random.RandomState) -> tuple[dict, Truth]:
    """Cut two images out of the Landsat scene; one has a cloud, and ground slid."""
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

    pixels, places = _grid(SIZE), 50 + 55 * _grid(5)
    reference = taken(pixels)
    grip = cv2.cornerMinEigenVal(reference.astype(np.float32), 15)

    def shifts(at: np.ndarray) -> np.ndarray:
        return shift + (at - CENTRE) @ (turned - np.eye(2))

    def slid(at: np.ndarray) -> np.ndarray:
        part = np.clip((35 - np.abs(at - slope).max(axis=1)) / 8, 0, 1)
        return part[:, None] * SLID * shift / np.hypot(*shift)

    low, high = (4.1, 0.6, 0.008, 0.0079), (4.4, 1.2, 0.01, 0.0101)  # px, px, 1, rad
    apart = 0.0
    while apart < 4:  # standard deviations: whole pixels, or 95 %, might pass
        # The best corner of eight places in each square of 31 by 31 pixels
        drawn = 36 + 31 * _grid(9) + chance.randint(-5, 6, (8, 81, 2))
        best = grip[drawn[..., 1], drawn[..., 0]].argmax(axis=0)
        points = drawn[best, np.arange(81)]
        signs = chance.choice([-1, 1], 4)
        one, other, m, turn = signs * chance.uniform(low, high).round(4)
        shift = chance.permutation([one, other])
        c, s = (1 + m) * np.cos(turn), (1 + m) * np.sin(turn)
        turned = np.array([(c, s), (-s, c)])
        # Where shifts are shortest: too short a search loses others, and it shows
        cloud = places[np.hypot(*shifts(places).T).argmin()]
        # Ground of four squares has slid; it looks as before, so that r is high
        slope = np.where(cloud < CENTRE, 175.5, 144.5)
        true = shifts(points)
        seen = (np.hypot(*(points - cloud).T) > CLOUD) & ~slid(points).any(axis=1)
        right, whole = (_adjusted(points[seen], d[seen]) for d in (true, np.rint(true)))
        next_to = np.quantile(np.hypot(*true[seen].T), 0.95) - right["ce90"]
        rounded = max(abs(right[name] - whole[name]) / SD[name] for name in SD)
        apart = min(rounded, next_to / SD["ce90"])

    def alike(by: np.ndarray) -> list[float]:
        moved = scipy.ndimage.shift(sensed, -by[::-1], order=1)
        pairs = ([cut(one, f, FIELD) for one in (reference, moved)] for f in fields)
        return [correlation(*pair) for pair in pairs]

    # A pixel of the sensed image shows the ground of this place of the reference
    back = (pixels - CENTRE - shift) @ np.linalg.inv(turned) + CENTRE
    sensed = taken(back - slid(back))
    texture = np.array([cut(reference, place, FIELD).std() for place in places])
    far = np.hypot(*(places - cloud).T) > CLOUD + 30
    far &= np.abs(places - slope).max(axis=1) > 65
    fields = places[np.sort(np.argsort(-np.where(far, texture, -1))[:FIELDS])]
    # The field that fits best before the warp, so that nothing shows it but the warp
    field = int(np.argmax(alike(shift)))
    # New ground of the same mean and contrast shines through, without a sharp border
    within = np.clip((28 - np.abs(back - fields[field]).max(axis=1)) / 8, 0, 1)
    within = within.reshape(SIZE, SIZE)
    was, new = sensed[within > 0], taken(back[:, ::-1])[within > 0]
    new = was.mean() + (new - new.mean()) * was.std() / new.std()
    sensed[within > 0] += MIXED * within[within > 0] * (new - was)
    shown = any(field in np.argsort(alike(by))[:2] for by in (shift, np.zeros(2)))
    sensed = sensed * chance.uniform(0.75, 0.95) + chance.uniform(5, 25)
    over = np.clip((CLOUD - np.hypot(*(back - cloud).T)) / 8, 0, 1)
    sensed += over.reshape(SIZE, SIZE) * (235 - sensed)
    reference, sensed = (
        grey(one + NOISE * chance.standard_normal(one.shape))
        for one in (reference, sensed)
    )
    search = registration.register(
        reference, sensed, points, 21, 9, "parabola", threshold=-1, ratio=1
    )
    at, off = search.shifts, np.hypot(*(search.shifts - true).T)
    used = [off < near for near in (0.3, 0.5, 0.7, 1)]  # by one program or another
    free, corner = used[0], dict(zip(SD, shifts(np.zeros(2))))
    answer = _adjusted(points[free], true[free]) | {"field": field}
    truth = Truth(answer, corner, points, true, at, search.r, free, reference, fields)

    def worst(given: Answer) -> float:
        return max(part.off for part in judge(truth, answer | given))

    ours = max(worst(_adjusted(points[some], at[some])) for some in used)
    if shown or ours > 1.3 or min(map(worst, slips(truth).values())) < 3.5:
        return make(chance)  # who is right must pass, who is wrong must not
    return {
        "reference.png": reference,
        "sensed.png": sensed,
        "points.csv": table("column,row", "{},{}", points),
        "fields.csv": table("column,row", "{},{}", fields),
    }, truth


@cache
def _landsat() -> np.ndarray:
    """Grey values of the scene, read once however often a task is drawn."""
    return datasets.landsat().grey


def _grid(n: int) -> np.ndarray:
    """Column and row (n², 2) of each pixel of a square, row by row."""
    return np.indices((n, n))[::-1].reshape(2, -1).T


def _adjusted(points: np.ndarray, shifts: np.ndarray) -> Answer:
    """What a program hands in that takes these points, and their shifts (n, 2)."""
    A = np.column_stack([np.ones(len(points)), points - CENTRE])
    shift, (m, t), _ = np.linalg.lstsq(A, shifts, rcond=None)[0]
    far = np.hypot(*shifts.T)
    size = np.sqrt(np.mean(far**2)), np.quantile(far, 0.9)
    turn = np.degrees(np.arctan2(t, 1 + m))
    return dict(zip(SD, (*shift, np.hypot(1 + m, t), turn, *size)))


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
    dx, dy, scale, turn, rmse, _, _ = truth.answer.values()
    free, true, whole = truth.free, truth.shifts[truth.free], np.rint(truth.found)
    every = np.abs(truth.found).max(axis=1) < 8.5
    near = free & (np.abs(truth.shifts).max(axis=1) < 5.5)

    def of(used: np.ndarray, shifts: np.ndarray = truth.found) -> Answer:
        return _adjusted(truth.points[used], shifts[used])

    return {
        "dx, dy: a shift is sensed minus reference.": {"dx": -dx, "dy": -dy},
        "dx is along the columns, dy along the rows.": {"dx": dy, "dy": dx},
        "dx, dy: at the centre of the image, not at pixel (0, 0).": truth.corner,
        "scale: are lengths in the sensed image larger or not?": {"scale": 1 / scale},
        "turn: clockwise is positive, and rows are counted downwards.": {"turn": -turn},
        "turn: degrees are wanted.": {"turn": np.radians(turn)},
        "rmse: of the shifts themselves, before any correction.": {"rmse": 0.1},
        "rmse: nothing is subtracted, not even the mean.": {
            "rmse": np.hypot(*true.std(axis=0))
        },
        "rmse: of both directions, not of one.": {
            "rmse": np.sqrt(np.mean(true[:, 0] ** 2))
        },
        "A high r does not make a shift right: ground that slid looks as before."
        " Compare each shift with the model.": of(every & (truth.r >= 0.8)),
        "Whole pixels are too coarse: refine each peak of r.": of(free, whole),
        "Points under the cloud or on changed ground do not count: their shifts are far"
        " from what the others say.": of(every),
        "Good points were left out, those with the longest shifts: search far enough,"
        " and compare each shift with the model, not with the median.": of(near),
        "ce90: nine of ten distances are below it. No normal distribution is needed.": {
            "ce90": 1.5175 * rmse
        },
        "ce90: nine of ten distances are below it, not 95 of a hundred.": {
            "ce90": np.quantile(np.hypot(*true.T), 0.95)
        },
    }


def hint(truth: Truth, found: Answer, wrong: list[str]) -> str:
    """Return the hint to the slip that explains a wrong value, or to the first one."""
    if words := likeliest(judge, truth, found, wrong, slips(truth)):
        return words
    if wrong == ["field"]:
        return (
            "field: fetch the sensed image to the reference first; where something new"
            " grows, r is lowest. The rows of the file count from 0."
        )
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
    points, shifts = truth.points[truth.free], truth.shifts[truth.free]
    ax.quiver(*points.T, *shifts.T, color=plot.YELLOW, **arrows)
    ax.set(title="shifts, five times as long", xlabel="column (px)", ylabel="row (px)")
    ax.grid(False)
    return fig, (
        f"The reference image with eight fields, field {field} in another colour, and"
        f" the true shifts of {len(points)} points as arrows, five times as long."
    )
