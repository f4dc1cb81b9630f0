"""The report of a matching: its numbers, and its warnings on both sides of limits."""

import re

import matplotlib.pyplot as plt
import numpy as np
import pytest

from pgm_lab import matching, report
from pgm_lab.matching import RECOMMENDED_QUALITY, STATUSES
from pgm_lab.report import _figures
from pgm_lab.report.matching import Case
from tests.matching import photos
from tests.report.pages import Page, joined, plain

MIXED = ["accepted"] * 30 + ["ambiguous"] * 4 + ["below threshold"] * 6
result, text = photos.result, report.matching.text


@pytest.fixture
def undrawn(monkeypatch):
    monkeypatch.setattr(_figures, "png", lambda figure: plt.close(figure) or "png")


# --- Numbers ---


def test_the_page_holds_the_numbers_of_the_result(undrawn):
    found = result(status=MIXED)
    page = report.matching.html(found, *photos.pair())
    words = joined(plain(page))
    assert "30 of 40 points were found; a typical one to 0.04 px" in words
    r = np.median(found.r[:30])
    assert f"Half of them have a correlation above {r:.3f}." in words
    assert "a typical point moves by -30 columns and 1 rows" in words
    for status in ("ambiguous", "below threshold"):
        assert all(one in words for one in STATUSES[status])
    _, *rows = Page(plain(page)).tables[
        "Points in pixels, columns to the right and rows down, from 0"
    ]
    assert [row[0] for row in rows] == [str(i) for i in range(40)]
    assert " ".join(rows[0][1:]) == (
        "17.00 14.00 -13.000 15.000 0.040 0.040 0.800 0.60 accepted"
    )
    assert rows[-1][3:7] == ["-"] * 4 and rows[-1][-1] == "below threshold"
    # Each figure says what it shows
    pair, histograms, parallaxes = (one["alt"] for one in Page(page).all("img"))
    assert "30 points marked in both" in pair
    assert "by reason: below threshold (6), ambiguous (4)." in pair
    assert "with the limit 0.7, and" in histograms
    assert "standard deviation below 0.04 px" in histograms
    assert "arrow at each match" in parallaxes


def test_the_text_holds_the_same_and_its_short_form_fits_a_terminal():
    found = result(status=MIXED)
    long, short = (text(found, short=one) for one in (False, True))
    assert "30 of 40 points were found" in long and "30 of 40" in short
    assert max(map(len, short.splitlines())) <= 88
    for status, number in (("ambiguous", 4), ("below threshold", 6)):
        assert re.search(rf"^{status} +{number}  ", long, re.MULTILINE)
        words = f"- {status}: {number} points: {STATUSES[status][0]}."
        assert words in joined(short)


def test_settings_are_those_given_and_the_defaults_of_the_others():
    def row(name, settings):
        words = text(result(), settings=settings)
        found = re.search(rf"^{name} +(\S+) ", words, re.MULTILINE)
        return found and found[1]

    given = {"template": 31, "start": "wide"}
    assert row("template", given) == "31" and row("start", given) == "wide"
    defaults = matching.match.__kwdefaults__
    assert row("search", given) == str(defaults["search"])
    assert row("points", given) is None
    given = {"points": np.zeros((40, 2))}
    assert row("points", given) == "given" and row("number", given) is None
    with pytest.raises(ValueError, match="settings: a name must be one of 'points', "):
        text(result(), settings={"windows": 31})


def test_few_matches_recommend_the_wide_start_unless_it_was_used():
    few = result(40, ["accepted"] * 9 + ["ambiguous"] * 31)
    assert "--start wide" in joined(text(few))
    assert "--start wide" not in text(few, settings={"start": "wide"})
    assert "--start wide" not in text(few, settings={"points": few.chosen})


def test_one_match_and_none_are_reported_too(undrawn):
    none = report.matching.html(result(2, ["ambiguous"] * 2), *photos.pair())
    assert "None of 2 points was found." in none and none.count("<img") == 1
    one = report.matching.html(result(1, sd=0.0), *photos.pair())
    assert one.count("<img") == 3


def test_another_photo_than_the_matched_one_is_refused():
    left, right = photos.pair()
    with pytest.raises(ValueError, match="left has 240 x 190 pixels, and the photo"):
        report.matching.html(result(), left[:190], right)


# --- Warnings ---


def findings(found):
    return Case(found, {}).findings


def rotated(degrees, scale=1.0):
    c, s = scale * np.cos(np.radians(degrees)), scale * np.sin(np.radians(degrees))
    return np.array([(c, -s), (s, c)])


def changed(name, *changes, **more):
    """A result with other values of some points."""
    found = result(**more)
    for at, value in changes:
        getattr(found, name)[at] = value
    return found


def part(corner):
    """Points in a corner; two that are elsewhere, perhaps wrong, do not hide it."""
    size = np.array(photos.SIZE)
    close = 0.3 * result(100).chosen + corner * (0.7 * size)
    close[-2:] = (1 - np.array(corner)) * (size - 1)
    return result(100, chosen=close)


def statuses(**numbers):
    """So many points of some statuses, the others of 40 accepted."""
    words = [word.replace("_", " ") for word, n in numbers.items() for _ in range(n)]
    return result(40, ["accepted"] * (40 - len(words)) + words)


Q = RECOMMENDED_QUALITY
FEW, DOUBT, MANY = "Few matches", "Doubtful matches", "Many ambiguous points"
PART, OTHER = "Matches in one part of the photo", "Rotated or scaled photo"
SIZES, WEAK, ONE = "Different sizes", "Imprecise matches", "Imprecise points"
MAKE = {
    "good": result,
    "11": lambda: result(11),
    "12": lambda: result(12),
    "10 lost": lambda: result(40, MIXED),
    "19 of 40": lambda: statuses(flat_template=21),
    "doubtful": lambda: changed("quality", (3, Q - 0.01), (12, 0), (4, Q)),
    "one doubtful": lambda: changed("quality", (3, 0)),
    "upper left": lambda: part((0, 0)),
    "lower right": lambda: part((1, 1)),
    "top": lambda: part((0.5, 0)),
    "7 ambiguous": lambda: statuses(ambiguous=7, below_threshold=1),
    "8 ambiguous": lambda: statuses(ambiguous=5, **{"left-right check failed": 3}),
    # Rows count down: from x to y is clockwise as one sees it
    "rotated": lambda: result(shape=rotated(30)),
    "back": lambda: result(shape=rotated(-20, 1.5)),
    "scaled": lambda: result(shape=rotated(2, 0.5)),
    "nearly alike": lambda: result(shape=rotated(14, 1.2)),
    "imprecise": lambda: result(sd=0.3),
    "one imprecise": lambda: changed("covariance", (5, 2 * np.eye(2))),
    "twice": lambda: result(shift=(0.001, -0.002)),
    "exchanged": lambda: result(shift=(30.0, 3.0)),
    "to the left": lambda: result(shift=(-30.0, 3.0)),
    "little to the right": lambda: result(shift=(10.0, 1.0)),
    "right and down": lambda: result(shift=(30.0, 40.0)),
    "upright": lambda: result(right_size=photos.SIZE[::-1]),
    "half": lambda: result(right_size=(120, 100)),
}
WARNED = [
    ("11", FEW, "11 points of 11 found."),
    ("19 of 40", FEW, "19 points of 40 found. Most often the reason is "),
    (
        "19 of 40",
        FEW,
        '"flat template" (21): all grey values are the same. Take a',
    ),
    (
        "doubtful",
        DOUBT,
        "2 matches of 40 have a quality below 0.5: 3 and 12. The",
    ),
    ("doubtful", DOUBT, "leave out --quality on the command line, or least_quality in"),
    ("one doubtful", DOUBT, "One match of 40 has a quality below 0.5: 3."),
    ("upper left", PART, "of the left photo, at the upper left. Whatever is"),
    ("lower right", PART, "at the lower right"),
    ("top", PART, "at the top"),
    ("8 ambiguous", MANY, "8 points of 40 resemble another place"),
    ("rotated", OTHER, "rotated by 30 degrees clockwise and 1 times as large"),
    ("back", OTHER, "20 degrees counterclockwise and 1.5 times"),
    ("scaled", OTHER, "0.5 times as large"),
    ("imprecise", WEAK, "A typical match has a standard deviation of 0.3 px"),
    ("one imprecise", ONE, "One point has a standard deviation above 1 px: 5."),
    ("twice", "No parallax", "Is it the same photo twice?"),
    ("exchanged", "Exchanged photos?", "30 px farther to the right"),
    ("upright", SIZES, "240 x 200 and 200 x 240 px. One is in portrait"),
    ("half", SIZES, "another camera"),
]


@pytest.mark.parametrize("name, title, words", WARNED)
def test_each_warning_comes_alone_and_says_why(name, title, words):
    ((named, said),) = findings(MAKE[name]())
    assert named == title and words in said


@pytest.mark.parametrize("name", sorted(set(MAKE) - {name for name, *_ in WARNED}))
def test_a_good_matching_is_not_warned_of(name):
    assert findings(MAKE[name]()) == []
    assert "No warnings." in text(MAKE[name]())


def test_the_share_of_a_part_is_that_of_its_points():
    ((_, words),) = findings(part((0, 0)))
    assert float(re.search(r"within (\d+) %", words)[1]) == pytest.approx(9, abs=2)


def test_odd_shapes_are_those_that_the_others_do_not_have():
    A = rotated(40, 1.3)
    stretched = (7, A @ np.diag([1.6, 1.0])), (9, np.diag([0.5, 1.0]) @ A)
    within = (11, A @ np.diag([1.4, 0.7]))
    said = dict(findings(changed("shape", *stretched, within, shape=A)))
    assert set(said) == {OTHER, "Odd shapes"}
    words = said["Odd shapes"]
    assert words.startswith("2 points have windows more than 1.5 times longer")
    assert ": 7 and 9. Steep" in words
