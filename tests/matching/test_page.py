"""The report of a matching: its numbers, its warnings, its page, and the drawings."""

import re

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.patches import ConnectionPatch
from matplotlib.quiver import Quiver

from pgm_lab import matching, plot, report
from pgm_lab.matching import STATUSES
from pgm_lab.report import _match_findings as findings
from tests.matching import photos
from tests.report.test_control import plain

MIXED = ["accepted"] * 30 + ["ambiguous"] * 4 + ["below threshold"] * 6


@pytest.fixture(scope="module")
def grey():
    return photos.pair()


@pytest.fixture(scope="module")
def page(grey):
    return report.matching.html(photos.result(status=MIXED), *grey, about="r^2.jpg")


def said(found, title):
    """The words of a warning; none if it is not given."""
    (words,) = [w for t, w in findings.findings(found) if t == title] or [""]
    return words


# ------------------------------------------------------------------------ numbers


def test_the_page_holds_the_numbers_of_the_result(page):
    text = plain(page)
    assert "30 of 40 points were found; a typical one to 0.04 px" in text
    r = photos.result(status=MIXED).r
    assert f"Half of them have a correlation above {np.median(r[:30]):.3f}." in text
    assert "a usual point moves by -30 columns and 1 rows" in text
    for status in ("ambiguous", "below threshold"):
        for words in STATUSES[status]:
            assert words in text
    assert "r^2.jpg" in page  # a name is never typeset
    rows = re.findall(r"<tr><th scope=\"row\">(\d+)</th>(.*?)</tr>", page)
    cells = [re.findall(r">([^<]*)</td>", row) for _, row in rows]
    assert [int(number) for number, _ in rows] == list(range(40))
    assert cells[0] == [
        *("17.00", "14.00", "−13.000", "15.000", "0.040", "0.040", "0.800", "0.60"),
        "accepted",
    ]
    assert cells[-1][2:6] == ["-"] * 4 and cells[-1][-1] == "below threshold"


def test_the_text_holds_the_same_and_its_short_form_fits_a_terminal():
    found = photos.result(status=MIXED)
    long, short = (report.matching.text(found, short=one) for one in (False, True))
    assert "30 of 40 points were found" in long and "30 of 40" in short
    assert max(map(len, short.splitlines())) <= 88
    for status, number in (("ambiguous", 4), ("below threshold", 6)):
        assert re.search(rf"^{status} +{number}  ", long, re.MULTILINE)
        words = " ".join(short.split())
        assert f"- {status}: {number} points: {STATUSES[status][0]}." in words


def test_a_long_table_shows_the_first_points_and_says_so():
    text = report.matching.text(photos.result(500))
    assert "the first 200 of 500" in text
    assert re.search(r"^ +199 ", text, re.MULTILINE)
    assert not re.search(r"^ +200 ", text, re.MULTILINE)


def test_settings_are_those_given_and_the_defaults_of_the_others():
    given = {"template": 31, "start": "pyramid"}
    text = report.matching.text(photos.result(), settings=given)
    defaults = matching.match.__kwdefaults__
    for name, value in (*given.items(), ("search", defaults["search"])):
        assert re.search(rf"^{name} +{value} ", text, re.MULTILINE)
    assert not re.search("^points ", text, re.MULTILINE)
    given = {"points": np.zeros((40, 2))}
    text = report.matching.text(photos.result(), settings=given)
    assert re.search("^points +given ", text, re.MULTILINE)
    assert not re.search("^number ", text, re.MULTILINE)
    with pytest.raises(ValueError, match="settings: a name must be one of 'points', "):
        report.matching.text(photos.result(), settings={"windows": 31})


def test_one_match_and_none_are_reported_too(grey):
    none = photos.result(2, ["ambiguous", "ambiguous"])
    html = report.matching.html(none, *grey)
    assert "None of 2 points was found." in html and html.count("<img") == 1
    one = photos.result(1, sd=0.0)
    assert report.matching.html(one, *grey).count("<img") == 3


# ----------------------------------------------------------------------- warnings


def test_a_good_matching_is_not_warned_of():
    assert findings.findings(photos.result()) == []
    assert "Nothing to warn of." in report.matching.text(photos.result())


def test_few_matches():
    words = said(
        photos.result(40, ["accepted"] * 19 + ["ambiguous"] * 21), "Few matches"
    )
    assert words.startswith(
        '19 points of 40 found. Most often the reason is "ambiguous"'
    )
    assert STATUSES["ambiguous"][0] in words and "Take a larger template" in words
    assert said(photos.result(40, MIXED), "Few matches") == ""
    assert said(photos.result(11), "Few matches") == "11 points of 11 found."
    assert said(photos.result(12), "Few matches") == ""


def test_doubtful_matches_are_those_of_little_quality():
    found = photos.result(status=MIXED)
    found.quality[[3, 12]] = matching.RECOMMENDED_QUALITY - 0.01, 0
    found.quality[4] = matching.RECOMMENDED_QUALITY
    words = said(found, "Doubtful matches")
    assert words.startswith("2 matches of 30 have a quality below 0.5: 3 and 12. The")
    assert "leave --quality out" in words and "least_quality in Python" in words
    assert said(photos.result(), "Doubtful matches") == ""


@pytest.mark.parametrize(
    "corner, place",
    [
        ((0, 0), "at the upper left"),
        ((1, 1), "at the lower right"),
        ((0.5, 0), "the top"),
    ],
)
def test_matches_in_one_part(corner, place):
    found = photos.result(100)
    size = np.array(photos.SIZE)
    close = 0.3 * found.chosen + corner * (0.7 * size)
    # two that lie elsewhere, perhaps wrong, do not hide it
    close[-2:] = (1 - np.array(corner)) * (size - 1)
    words = said(photos.result(100, chosen=close), "Matches in one part of the photo")
    assert place in words
    assert float(re.search(r"within (\d+) %", words)[1]) == pytest.approx(9, abs=2)
    assert said(found, "Matches in one part of the photo") == ""


def test_many_ambiguous_points():
    status = ["ambiguous"] * 5 + ["left-right check failed"] * 3 + ["accepted"] * 32
    assert "8 points of 40" in said(
        photos.result(status=status), "Many ambiguous points"
    )
    status[0] = "below threshold"
    assert said(photos.result(status=status), "Many ambiguous points") == ""


def turned(degrees, scale):
    c, s = scale * np.cos(np.radians(degrees)), scale * np.sin(np.radians(degrees))
    return np.array([(c, -s), (s, c)])


def test_turned_and_scaled_photos():
    """Rows count down: from x to y is clockwise as one sees it."""
    title = "Turned or scaled photo"
    words = said(photos.result(shape=turned(30, 1)), title)
    assert "turned by 30 degrees clockwise and 1 times as large" in words
    words = said(photos.result(shape=turned(-20, 1.5)), title)
    assert "20 degrees counterclockwise and 1.5 times" in words
    assert "0.5 times" in said(photos.result(shape=turned(2, 0.5)), title)
    assert said(photos.result(shape=turned(14, 1.2)), title) == ""


def test_a_mirrored_photo():
    mirrored = photos.result(shape=np.diag([-1.0, 1.0]))
    assert "mirror image" in said(mirrored, "Mirrored photo")
    assert said(mirrored, "Turned or scaled photo") == ""


def test_odd_shapes_are_those_that_the_others_do_not_have():
    found = photos.result(shape=turned(40, 1.3))
    found.shape[7] = turned(40, 1.3) @ np.diag([1.6, 1.0])
    found.shape[9] = np.diag([0.5, 1.0]) @ turned(40, 1.3)
    found.shape[11] = turned(40, 1.3) @ np.diag([1.4, 0.7])
    words = said(found, "Odd shapes")
    assert words.startswith("2 points have windows") and ": 7 and 9. Steep" in words
    assert said(photos.result(), "Odd shapes") == ""


def test_imprecise_matches_and_points():
    assert "0.3 px" in said(photos.result(sd=0.3), "Imprecise matches")
    found = photos.result()
    found.covariance[5] *= 30**2
    assert said(found, "Imprecise matches") == ""
    assert "One point has" in said(found, "Imprecise points")
    assert "above 1 px: 5." in said(found, "Imprecise points")


def test_the_same_photo_twice_and_photos_exchanged():
    twice = photos.result(shift=(0.001, -0.002))
    assert "Is it the same photo twice?" in said(twice, "No parallax")
    exchanged = photos.result(shift=(30.0, 3.0))
    words = said(exchanged, "Exchanged photos?")
    assert "30 px farther to the right" in words
    for shift in ((-30.0, 3.0), (10.0, 1.0), (30.0, 40.0)):
        assert said(photos.result(shift=shift), "Exchanged photos?") == ""


def test_photos_of_two_sizes():
    words = said(photos.result(right_size=photos.SIZE[::-1]), "Different sizes")
    assert "240 x 200 and 200 x 240 px. One was held upright" in words
    words = said(photos.result(right_size=(120, 100)), "Different sizes")
    assert "another camera" in words


def test_each_limit_is_stated_with_its_value():
    text = " ".join(findings.limits())
    for value in (
        "twelve",
        "20 %",
        "15 degrees",
        "1.25",
        "1.5",
        "0.2 px",
        "1 px",
        "0.02",
    ):
        assert value in text


# ------------------------------------------------------------------------- drawings


@pytest.fixture
def close():
    yield
    plt.close("all")


def test_each_status_has_its_mark_and_each_match_two(grey, close):
    found = photos.result(status=MIXED)
    left, right = plot.matches.side_by_side(*grey, found).axes
    names = [line.get_label() for line in left.lines]
    assert names == ["accepted: 30", "below threshold: 6", "ambiguous: 4"]
    looks = [(line.get_color(), line.get_marker()) for line in left.lines]
    assert len({c for c, _ in looks}) == len({m for _, m in looks}) == 3
    np.testing.assert_array_equal(left.lines[0].get_xydata(), found.chosen[:30])
    np.testing.assert_array_equal(left.lines[2].get_xydata(), found.chosen[30:34])
    (marks,) = right.lines
    np.testing.assert_array_equal(marks.get_xydata(), found.points[:30])


def test_rare_statuses_share_the_last_mark(grey, close):
    status = ["accepted", *STATUSES, *STATUSES][:28]
    found = photos.result(28, status)
    left, _ = plot.matches.side_by_side(*grey, found).axes
    names = [line.get_label() for line in left.lines]
    assert len(names) == 7 and names[-1].startswith("other reasons: ")
    assert sum(int(name.rpartition(": ")[2]) for name in names) == 28


@pytest.mark.parametrize("lines", [0, 5, 12])
def test_lines_join_a_few_matches_far_apart(grey, close, lines):
    found = photos.result(status=MIXED)
    fig = plot.matches.side_by_side(*grey, found, lines=lines)
    drawn = [one for one in fig.artists if isinstance(one, ConnectionPatch)]
    ends = {(tuple(one.xy1), tuple(one.xy2)) for one in drawn}
    assert len(ends) == lines
    matches = set(zip(map(tuple, found.chosen), map(tuple, found.points)))
    assert ends <= matches
    if lines == 5:
        starts = np.array([start for start, _ in ends])
        assert np.all(np.ptp(starts, axis=0) >= 0.7 * np.ptp(found.chosen, axis=0))


def test_a_large_photo_is_drawn_coarser_in_its_own_pixels(close):
    big = np.add.outer(np.arange(2600.0), np.arange(3700.0))
    found = photos.result(4, size=(3700, 2600))
    ax, _ = plot.matches.side_by_side(big, big, found).axes
    (shown,) = ax.images
    assert max(shown.get_array().shape) <= 1200
    x, y = 1850, 1300
    left, right, bottom, top = shown.get_extent()
    rows, columns = shown.get_array().shape
    i, j = (
        int((y - top) / (bottom - top) * rows),
        int((x - left) / (right - left) * columns),
    )
    assert shown.get_array()[i, j] == pytest.approx(x + y, abs=8)


def test_what_has_no_data_is_blank(grey, close):
    left = np.ma.array(grey[0], mask=np.zeros(grey[0].shape, bool))
    left[:50] = np.ma.masked
    ax, _ = plot.matches.side_by_side(left, grey[1], photos.result()).axes
    mask = np.ma.getmaskarray(ax.images[0].get_array())
    assert mask[:50].all() and not mask[50:].any()


def test_another_photo_than_the_matched_one_is_refused(grey):
    with pytest.raises(
        ValueError, match="left has 240 x 190 pixels, and the photo that"
    ):
        plot.matches.side_by_side(grey[0][:190], grey[1], photos.result())


def test_remainders_are_what_no_affine_transformation_explains():
    """Of 40 points three are wrong; the others fit all the same."""
    A = np.array([(1.1, 0.2), (-0.15, 0.9)])
    found = photos.result()
    points = found.chosen @ A.T + (30, -7)
    points[[3, 20, 33]] += (25, -12)
    v = plot.matches.remainders(photos.result(points=points))
    good = np.delete(np.arange(40), [3, 20, 33])
    assert np.abs(v[good]).max() < 0.01
    np.testing.assert_allclose(v[[3, 20, 33]], np.tile((25.0, -12), (3, 1)), atol=0.01)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_few_points_leave_no_remainder(n):
    assert np.abs(plot.matches.remainders(photos.result(n))).max() < 1e-9


def test_arrows_are_long_as_they_say_and_far_ones_red(grey, close):
    rng = np.random.default_rng(3)
    found = photos.result()
    points = found.points + rng.normal(0, 0.5, (40, 2))
    points[8] += 30
    found = photos.result(points=points)
    ax = plot.matches.parallaxes(grey[0], found).axes[0]
    far, near = [one for one in ax.collections if isinstance(one, Quiver)]
    v = plot.matches.remainders(found)
    drawn = np.column_stack([near.U, near.V])
    np.testing.assert_allclose(drawn, np.delete(v, 8, axis=0))
    np.testing.assert_array_equal(far.get_offsets(), found.chosen[[8]])
    assert np.hypot(far.U, far.V) < np.hypot(*v[8])
    assert "red ones are longer" in ax.get_title()


def test_histograms_hold_every_point_and_their_limits(close):
    found = photos.result(status=MIXED)
    above, below = plot.matches.histograms(found, threshold=0.7).axes
    counts = [sum(bar.get_height() for bar in one) for one in above.containers]
    assert counts == [40, 30]
    assert sum(bar.get_height() for bar in below.containers[0]) == 30
    assert above.lines[0].get_xdata()[0] == 0.7
    assert below.lines[0].get_xdata()[0] == pytest.approx(0.04)


def test_every_figure_says_what_it_shows(page):
    texts = re.findall(r'<img [^>]*alt="([^"]+)"', page)
    assert len(texts) == 3
    assert (
        "30 points marked in both" in texts[0]
        and "below threshold (6), ambiguous (4)" in texts[0]
    )
    assert "limit 0.7" in texts[1] and "standard deviation below 0.04 px" in texts[1]
    assert "arrow at each match" in texts[2]
