"""The report of a registration: its numbers, and warnings on both sides of limits."""

import re
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import pytest

from pgm_lab import registration, report
from pgm_lab.matching import STATUSES
from pgm_lab.report import _figures
from pgm_lab.report import registration as module
from pgm_lab.report.registration import COMMON, WORDS
from tests.registration import images
from tests.report.pages import Page, joined, plain

MIXED = ["accepted"] * 30 + ["ambiguous"] * 4 + ["below threshold"] * 6
LSM = {"refine": "lsm"}
BLANK = np.resize(np.arange(251, dtype=np.uint8), (images.ROWS, images.COLUMNS))
result, fit = images.result, registration.fit


@pytest.fixture(scope="module")
def pair():
    return images.pair()


@pytest.fixture(scope="module")
def found(pair):
    points = registration.pick(pair[0], 40, sensed=pair[1])
    return registration.register(*pair, points, refine="lsm")


def case(found, model=None, settings=LSM):
    """What the report is made of, of two images that are never looked at."""
    return module.Case(found, BLANK, BLANK, model, settings=settings)


def said(found, **more):
    return dict(case(found, **more).findings)


def text(found, **more):
    return report.registration.text(found, BLANK, BLANK, **{"settings": LSM} | more)


def first(found, **more):
    """The summary."""
    return joined(text(found, short=True, **more).partition("\n\n\n")[0])


def line(text, name):
    """Words of a row of a table of the text report."""
    (row,) = re.findall(f"^{re.escape(name)}  +(.*)$", text, re.MULTILINE)
    return row.split()


def test_a_file_that_places_an_image_is_named(found):
    both = [replace(images.raster(BLANK), beside=name) for name in ("a.tfw", "")]
    (words,) = (
        words
        for title, words in module.Case(found, *both, settings=LSM).findings
        if title == "A file beside the reference image"
    )
    assert "lies on the map is taken from a.tfw beside it" in words
    assert "beside" not in joined(text(found))


def test_an_offset_is_said_unless_it_is_that_of_the_maps(found):
    corner = images.CORNER[0] + 3 * images.SIZE, images.CORNER[1]
    both = images.raster(BLANK), images.raster(BLANK, corner)
    for offset, told in (((-3.0, 0.0), False), ((4.0, 0.0), True)):
        settings = LSM | {"offset": offset}
        words = joined(report.registration.text(found, *both, settings=settings))
        assert ("Counted from an offset" in words) == told
        assert ("image moved by the offset that was given" in words) == told


def test_a_value_that_may_stand_for_missing_data_is_named():
    dark, marked = images.raster(BLANK.copy()), np.zeros(BLANK.shape, bool)
    marked[:20] = True
    dark.grey[marked] = 0
    words = "13 % of the sensed image have the value 0, a corner among them. If"
    assert module.unmarked(images.raster(BLANK), dark).startswith(words)
    assert module.unmarked(replace(dark, mask=marked), images.raster(BLANK)) == ""


# --- Numbers ---


def test_the_page_holds_the_numbers_of_the_result(pair, found, monkeypatch):
    monkeypatch.setattr(_figures, "png", lambda figure: plt.close(figure) or "png")
    more = {"model": fit(found), "settings": LSM}
    page = report.registration.html(found, *map(images.raster, pair), **more)
    words = joined(plain(page))
    assert "lies 1.25 px (7.5 m) east and 0.50 px (3.0 m) north of the ref" in words
    assert "known to about 0.01 px (0.1 m)" in words
    assert f"{np.sum(found.accepted)} of 40 points were accepted." in words
    assert "RMSE<sub>T</sub>" in page and "a<sub>0</sub>" in page
    (table,) = [
        rows for name, rows in Page(plain(page)).tables.items() if "Points" in name
    ]
    assert [row[0] for row in table[1:]] == [str(i) for i in range(40)]
    for row, at, dx, status in zip(table[1:], found.points, found.dx, found.status):
        assert [float(one) for one in row[1:3]] == at.tolist()
        assert row[-1] == WORDS[status][0]
        if np.isfinite(dx):
            assert float(row[3]) == pytest.approx(dx, abs=6e-4)
    alts = [one["alt"] for one in Page(page).all("img")]
    for alt, shown in zip(alts, ("fringes", "CE90", "arrow", "arrow", "their r")):
        assert shown in alt


def test_accuracies_are_those_that_anybody_computes(found):
    """From the shifts alone, by their definitions."""
    good = found.status == "accepted"
    dx, dy = found.dx[good], found.dy[good]
    length = np.sort(np.hypot(dx, dy))
    rmse = [np.sqrt(np.sum(one**2) / len(one)) for one in (dx, dy)]
    at = 0.9 * (len(length) - 1)
    low = int(at)
    in_metres, in_pixels = text(found, pixel_size=6.0), text(found)
    for name, value in (
        ("mean dx", dx.mean()),
        ("mean dy", dy.mean()),
        ("RMSE_x", rmse[0]),
        ("RMSE_y", rmse[1]),
        ("RMSE_T", np.sqrt(rmse[0] ** 2 + rmse[1] ** 2)),
        ("CE90", length[low] + (at - low) * (length[low + 1] - length[low])),
        ("median dx", np.median(dx)),
    ):
        px, metres = map(float, line(in_metres, name)[:2])
        assert px == pytest.approx(value, abs=6e-4)
        assert metres == pytest.approx(6 * value, abs=6e-4)
        assert float(line(in_pixels, name)[0]) == pytest.approx(value, abs=6e-4)
    assert line(in_pixels, "RMSE_x")[1] == "root"
    assert "Not in metres: the size of a pixel" in joined(in_pixels)


@pytest.mark.parametrize("kind", ["shift", "affine"])
def test_the_model_is_shown_with_its_standard_deviations(found, kind):
    model = fit(found, kind)
    words = text(found, model=model)
    for name, value, sd in zip(model.names, model.parameters, model.sd):
        shown, uncertain = map(float, line(words, name)[:2])
        assert shown == pytest.approx(value, abs=0.06 * sd)
        assert uncertain == pytest.approx(sd, rel=0.06)
    assert f"redundancy {model.redundancy}" in joined(words)


def test_every_status_is_said_in_words_of_images():
    """But for those that only a matching gives."""
    only = {"left-right check failed", "parts disagree"}
    assert set(WORDS) == set(STATUSES) and only < set(WORDS)
    for status in set(WORDS) - only:
        for foreign in ("photo", "left image", "right", "template", "epipolar"):
            assert not any(foreign in words for words in WORDS[status])


@pytest.mark.parametrize(
    "more, message",
    [
        ({"settings": {"windows": 31}}, "settings: a name must be one of 'points', "),
        # Shifts between pixels are never called whole
        ({"settings": None}, "settings must say how the shifts were refined"),
        ({"model": fit(result(20))}, "model is of 20 points, and found has 40"),
    ],
)
def test_what_does_not_belong_together_is_refused(more, message):
    with pytest.raises(ValueError, match=message):
        text(result(), **more)


def test_one_point_and_none_are_reported_too(pair, monkeypatch):
    monkeypatch.setattr(_figures, "png", lambda figure: plt.close(figure) or "png")
    html = report.registration.html(result(2, ["ambiguous"] * 2), *pair)
    assert "None of 2 points was accepted" in html and html.count("<img") == 1
    html = report.registration.html(result(1, scatter=0), *pair, settings=LSM)
    assert html.count("<img") == 4 and "1.25 px farther to the right" in html


# --- The headline ---


@pytest.mark.parametrize(
    "more, words",
    [
        (
            {"shift": (1.25, -0.5), "scatter": 1e-4},
            "1.25 px farther to the right and 0.50 px higher than the reference image",
        ),
        (
            {"shift": (-2.0, 0.75), "scatter": 1e-4},
            "2.00 px farther to the left and 0.75 px lower than",
        ),
        ({"shift": (0.0, 0.75), "scatter": 1e-4}, "lies 0.75 px lower than"),
        (
            {"shift": (0.005, -0.003), "scatter": 0.01},
            "40 points show no common shift, and one of 0.02 px or more would",
        ),
    ],
)
def test_the_shift_in_words(more, words):
    assert words in first(result(**more))


def test_a_few_blunders_do_not_move_the_headline():
    found = result(scatter=0.005)
    found.dx[:5] += 2.5
    assert "1.25 px farther to the right" in first(found)


def test_the_headline_never_knows_more_than_all_points_share():
    """However small their scatter; and the scatter counts where it is larger."""
    for refine, least in COMMON.items():
        found = result(400, scatter=1e-6, sd=1e-6 if refine else 0.289)
        of = case(found, settings={"refine": refine})
        assert of.known == pytest.approx(least, rel=1e-3)
    left = case(result(400, scatter=1e-6), settings=LSM | {"smooth": 0.0})
    assert left.known == pytest.approx(0.03, rel=0.01)
    found = result(25, scatter=0.5, sd=0.01)
    robust = 1.4826 * np.median(np.abs(found.dx - np.median(found.dx)))
    assert case(found).known >= robust / 5


# --- Warnings ---


def lot(n):
    """Shifts drawn by lot from the window within its border."""
    drawn = np.random.default_rng(1).integers(-2, 3, (2, 4000)).astype(float)
    return {"dx": drawn[0, :n], "dy": drawn[1, :n]}


def statuses(**numbers):
    """So many points of some statuses, the others of 40 accepted."""
    words = [word for name, n in numbers.items() for word in [name] * n]
    words = [word.replace("_", " ") for word in words]
    return result(40, ["accepted"] * (40 - len(words)) + words)


def rotated(by):
    found = result()
    x, y = found.points.T
    return result(dx=found.dx - by * y, dy=found.dy + by * x)


def blunders(*at):
    found = result()
    found.dx[list(at)] += 1.5
    return found


DISAGREE, TWICE, FEW = "Shifts that do not agree", "No difference", "Few points"
BORDER, FAR = "Peaks on the border of the search", "A shift beyond half the radius"
OTHER, PART = "Places that look different", "Points in one part of the image"
TREND, NOISE = "A shift that changes over the image", "More scatter than predicted"
BLUNDERS, WHOLE = "Accepted points that do not fit", "Whole pixels only"
OFFSET = "Counted from an offset"
PEAK = "peak_on_the_border_of_the_search"
MAKE = {  # a result, and what else the report is given; a model is fitted to it
    "good": (result, {}),
    "a model": (result, {"model": "shift"}),
    "scattered": (lambda: result(scatter=0.3), {}),
    "no shift": (lambda: result(shift=(0, 0)), {}),
    "lot": (lambda: result(30, **lot(30)), {}),
    "same": (lambda: result(dx=np.zeros(40), dy=np.zeros(40), r=np.ones(40)), {}),
    "11 points": (lambda: result(11), {}),
    "12 points": (lambda: result(12), {}),
    "19 of 40": (lambda: statuses(ambiguous=21), {}),
    "3 peaks": (lambda: statuses(**{PEAK: 3}), {}),
    "4 peaks": (lambda: statuses(**{PEAK: 4}), {}),
    "7 changed": (lambda: statuses(changed=5, below_threshold=2, ambiguous=1), {}),
    "8 changed": (lambda: statuses(changed=5, below_threshold=3), {}),
    "1.4 px": (lambda: result(shift=(1.4, 0)), {}),
    "2.2 px": (lambda: result(shift=(1.6, -2.2)), {}),
    "from 10, 7": (lambda: result(shift=(1.0, 0.8)), {"offset": (10.0, 7.0)}),
    "a corner": (lambda: result(points=result().points * 0.3), {}),
    "rotated": (lambda: rotated(0.002), {"model": "shift"}),
    "rotated much": (lambda: rotated(0.02), {"model": "shift"}),
    "rotated, affine": (lambda: rotated(0.002), {"model": "affine"}),
    "some noise": (lambda: result(scatter=0.03, seed=2), {"model": "shift"}),
    "noise": (lambda: result(scatter=0.06, seed=2), {"model": "shift"}),
    "blunder": (lambda: blunders(4), {"model": "shift"}),
    "blunders": (lambda: blunders(4, 17), {"model": "shift"}),
    "whole": (lambda: result(sd=0.289), {"refine": None}),
}
WARNED = [
    ("lot", DISAGREE, "a guess is off by 1.4 px (sd) in each"),
    ("same", TWICE, "Is it the same image twice?"),
    (
        "19 of 40",
        FEW,
        '19 points of 40 found. Most often the reason is "ambiguous"',
    ),
    ("19 of 40", FEW, "almost as similar. Take a larger chip, or a smaller radius."),
    ("11 points", FEW, "11 points of 11 found."),
    ("4 peaks", BORDER, "4 points of 40 fit best at the border of what was searched"),
    ("4 peaks", BORDER, "3 px to each side"),
    ("2.2 px", FAR, "2.2 px is more than half the radius of 3 px"),
    ("2.2 px", FAR, "with --radius 6, or leave --radius out"),
    ("from 10, 7", OFFSET, "the offset of 10 columns and 7 rows that was given."),
    ("from 10, 7", OFFSET, "found 11 columns and 7.8 rows from its own place"),
    ("8 changed", OTHER, "8 points of 40 have texture in the reference image"),
    ("a corner", PART, "of the reference image, at the upper left."),
    ("rotated", TREND, "are rotated or sheared"),
    ("rotated much", TREND, "changes by up to 1."),  # and not by chance
    ("noise", NOISE, "that many times farther from the model"),
    ("blunders", BLUNDERS, "2 points do not follow the model and were left out of it:"),
    ("blunders", BLUNDERS, "of it: 4 and 17."),
    (
        "blunder",
        BLUNDERS,
        "One point does not follow the model and was left out",
    ),
    ("whole", WHOLE, "no better than a third of a pixel"),
]


def made(name):
    """The warnings of a result."""
    make, more = MAKE[name]
    found, more = make(), dict(more)
    kind = more.pop("model", None)
    return said(found, model=kind and fit(found, kind), settings=LSM | more)


@pytest.mark.parametrize("name, title, words", WARNED)
def test_each_warning_comes_alone_and_says_why(name, title, words):
    found = made(name)
    assert list(found) == [title] and words in found[title]


@pytest.mark.parametrize("name", sorted(set(MAKE) - {name for name, *_ in WARNED}))
def test_a_good_registration_is_not_warned_of(name):
    assert made(name) == {}


def test_numbers_of_warnings_are_those_of_the_result():
    chance = case(result()).chance
    assert chance == pytest.approx(lot(4000)["dx"].std(), rel=0.02)
    assert "No common shift was found: 30 of 30 points" in first(result(30, **lot(30)))
    assert DISAGREE in said(result(5, **lot(5)))  # an affine one fits nearly
    two = statuses(ambiguous=38)
    assert "One or two of many points may fit by chance" in said(two)[DISAGREE]
    assert "2 of 40 points were accepted, too few to confirm each other" in first(two)
    assert DISAGREE not in said(result(2))
    points = result().points
    share = np.prod(0.3 * np.ptp(points, axis=0)) / (images.ROWS * images.COLUMNS)
    words = said(result(points=0.3 * points))[PART]
    stated = float(re.search(r"within (\d+) %", words)[1])
    assert stated == pytest.approx(100 * share, abs=2)
    turned = rotated(0.002)
    assert fit(turned).sigma0 > 3
    words = said(turned, model=fit(turned))[TREND]
    stated = float(re.search(r"up to ([\d.]+) px", words)[1])
    assert stated == pytest.approx(0.002 * np.ptp(points[:, 0]) / 2, rel=0.2)
    noisy = result(scatter=0.1, sd=0.02)
    stated = re.match(r"sigma0 is ([\d.]+):", said(noisy, model=fit(noisy))[NOISE])[1]
    assert float(stated) == pytest.approx(5, rel=0.25)


def test_an_image_that_is_mirrored_is_told_where_few_points_are_found():
    reference, sensed = images.pair()
    title = "An image turned, scaled, mirrored or inverted"
    for lost, told in ((0, False), (25, True)):
        found = statuses(below_threshold=lost)
        pair = reference, sensed[:, ::-1]
        words = dict(module.Case(found, *pair, settings=LSM).findings)
        assert (title in words) is told
    assert "the sensed image is mirrored, left to right. Take in" in words[title]


def bent(by):
    """Shifts of one wave over the image."""
    found = result(100)
    x, y = found.points.T / 30
    return result(100, dx=found.dx + by * np.sin(x), dy=found.dy + by * np.cos(y))


def test_what_neighbours_share_is_in_what_the_shift_is_known_to():
    """Of 16 parts of 25 points, 0.1 px each: 0.1 / 4; their scatter says 0.006."""
    of_parts = []
    for seed in range(20):
        x, y = np.indices((20, 20)).reshape(2, -1)
        part = x // 5 * 4 + y // 5
        error = np.random.default_rng(seed).normal(0, 0.1, (16, 2))[part]
        found = result(400, points=np.column_stack([x, y]) * 10.0 + 5)
        of_parts.append(module._of_parts(found.points, error))
    # Of the larger of two standard deviations
    assert np.mean(of_parts) == pytest.approx(0.1 / 4, rel=0.2)
    assert module._of_parts(found.points[:5], error[:5]) == 0
    shared = result(400, points=found.points, dx=error[:, 0], dy=error[:, 1])
    assert case(shared).known == pytest.approx(np.hypot(of_parts[-1], 0.01), rel=1e-6)


def test_a_shift_that_bends_is_told_from_one_that_turns():
    (title,) = said(bent(0.5), model=fit(bent(0.5)))
    assert title == "A shift that changes from place to place"
    assert title not in said(bent(0.5), model=fit(bent(0.5), "local"))
    # A tenth less is no reason
    assert title not in said(bent(0.025), model=fit(bent(0.025)))


@pytest.mark.slow
def test_a_start_and_a_low_threshold_are_told():
    reference, sensed, _ = images.uneven((18.0, -11.0))
    start = registration.approximate(reference, sensed)
    points = registration.pick(reference, 60, sensed=sensed, offset=start.typical)
    how = {"refine": "lsm", "start": start.shifts(points), "radius": start.radius}
    found = registration.register(reference, sensed, points, **how, threshold=0.4)
    given = how | {"threshold": 0.4}
    told = dict(
        module.Case(found, reference, sensed, None, start, settings=given).findings
    )
    words = told["A start from reduced images"]
    assert f"{start.found} of {start.tried} large chips" in words
    assert f"reached {start.radius} px" in words
    words = told["Images that look different"]
    assert (
        f"The median r is {np.nanmedian(found.r):.2f}" in words and "r = 0.4" in words
    )


# --- What the overlay shows ---
