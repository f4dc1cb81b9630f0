"""The report of a registration: its numbers, its warnings, its page, the drawings."""

import re
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.patches import Circle
from matplotlib.quiver import Quiver

from pgm_lab import plot, registration, report
from pgm_lab.matching import STATUSES
from pgm_lab.report import _registration_figures
from pgm_lab.report import _registration_findings as findings
from pgm_lab.report import registration as page_of
from pgm_lab.report._registration_case import COMMON, say
from tests.registration import images
from tests.report.test_control import plain

MIXED = ["accepted"] * 30 + ["ambiguous"] * 4 + ["below threshold"] * 6
BORDER = "peak on the border of the search"
LSM = {"refine": "lsm"}


@pytest.fixture(scope="module")
def pair():
    return images.pair()


@pytest.fixture(scope="module")
def found(pair):
    points = registration.pick(pair[0], 40, sensed=pair[1])
    return registration.register(*pair, points, refine="lsm")


@pytest.fixture(scope="module")
def page(pair, found):
    words = {"model": registration.fit(found), "settings": LSM, "about": "r^2.png"}
    on_map = map(images.raster, pair)
    return report.registration.html(found, *on_map, **words)


def case(found, model=None, settings=LSM, **more):
    """What the report is made of, of two images that are never looked at."""
    blank = np.zeros((images.ROWS, images.COLUMNS), np.uint8) + 7
    both = images.raster(blank), images.raster(blank)
    return page_of._case(found, *both, model, None, settings, "", **more)


def said(found, title, **more):
    """The words of a warning; none if it is not given."""
    of = findings.findings(case(found, **more))
    (words,) = [words for name, words in of if name == title] or [""]
    return words


def text(found, **more):
    blank = np.zeros((images.ROWS, images.COLUMNS), np.uint8) + 7
    words = {"settings": LSM} | more
    return report.registration.text(found, blank, blank, **words)


def line(text, name):
    """Words of a row of a table of the text report."""
    (row,) = re.findall(f"^{re.escape(name)}  +(.*)$", text, re.MULTILINE)
    return row.split()


# ------------------------------------------------------------------------ numbers


def test_the_headline_is_the_known_shift(page, found):
    words = plain(page)
    assert "lies 1.25 px (7.5 m) east and 0.50 px (3.0 m) north of the ref" in words
    assert "known to about 0.01 px (0.1 m)" in words
    assert f"{np.sum(found.accepted)} of 40 points were accepted." in words


def test_accuracies_are_those_that_anybody_computes(found):
    """From the shifts alone, by their definitions."""
    good = found.status == "accepted"
    dx, dy = found.dx[good], found.dy[good]
    length = np.sort(np.hypot(dx, dy))
    rmse = [np.sqrt(np.sum(one**2) / len(one)) for one in (dx, dy)]
    at = 0.9 * (len(length) - 1)
    low = int(at)
    ce90 = length[low] + (at - low) * (length[low + 1] - length[low])
    text_ = text(found, pixel_size=6.0)
    for name, value in (
        ("mean dx", dx.mean()),
        ("mean dy", dy.mean()),
        ("RMSE_x", rmse[0]),
        ("RMSE_y", rmse[1]),
        ("RMSE_T", np.sqrt(rmse[0] ** 2 + rmse[1] ** 2)),
        ("CE90", ce90),
        ("median dx", np.median(dx)),
    ):
        px, metres = map(float, line(text_, name)[:2])
        assert px == pytest.approx(value, abs=6e-4)
        assert metres == pytest.approx(6 * value, abs=6e-4)
    pixels_only = text(found)
    assert float(line(pixels_only, "RMSE_x")[0]) == pytest.approx(rmse[0], abs=6e-4)
    assert line(pixels_only, "RMSE_x")[1] == "root"
    assert "Not in metres: the size of a pixel" in " ".join(pixels_only.split())


def test_ce90_of_normal_errors_is_1_517_times_their_rmse():
    drawn = np.random.default_rng(2).normal(0, 0.3, (200_000, 2))
    length = np.hypot(*drawn.T)
    ratio = np.quantile(length, 0.9) / np.sqrt(np.mean(length**2))
    assert pytest.approx(ratio, abs=0.005) == page_of.RATIO
    assert "CE90 is 1.517 times RMSE_T" in " ".join(text(images.result()).split())


def test_what_resampling_leaves_is_the_scatter():
    found = images.result(shift=(1.0, 0.0), scatter=0.1, seed=5)
    d = np.column_stack([found.dx, found.dy])
    left = np.sqrt(np.mean(np.sum((d - d.mean(axis=0)) ** 2, axis=1)))
    words = " ".join(text(found).split())
    assert f"removes it; {left:.3f} px would be left" in words
    assert "would be left" not in text(images.result(shift=(0, 0), scatter=0.1))


def test_the_model_stands_with_its_standard_deviations(found):
    for kind in ("shift", "affine"):
        model = registration.fit(found, kind)
        words = text(found, model=model)
        for name, value, sd in zip(model.names, model.parameters, model.sd):
            shown, uncertain = map(float, line(words, name)[:2])
            assert shown == pytest.approx(value, abs=0.06 * sd)
            assert uncertain == pytest.approx(sd, rel=0.06)
        assert f"redundancy {model.redundancy}" in words


def test_a_large_sigma0_is_explained():
    found = images.result(scatter=0.2, sd=0.02)
    model = registration.fit(found)
    assert model.sigma0 > 5
    words = " ".join(text(found, model=model).split())
    assert "which is more than the noise of the chips explains" in words
    found = images.result(scatter=0.02)
    words = " ".join(text(found, model=registration.fit(found)).split())
    assert "so that the noise of the chips explains their scatter" in words


def test_the_page_holds_all_points_and_no_word_of_photos(page, found):
    rows = re.findall(r"<tr><th scope=\"row\">(\d+)</th>(.*?)</tr>", page)
    cells = [re.findall(r">([^<]*)</td>", row) for _, row in rows]
    assert [int(number) for number, _ in rows] == list(range(40))
    for cell, at, dx, status in zip(cells, found.points, found.dx, found.status):
        assert [float(one) for one in cell[:2]] == at.tolist()
        assert cell[-1] == status
        if np.isfinite(dx):
            assert float(cell[2].replace("−", "-")) == pytest.approx(dx, abs=6e-4)
    assert "r^2.png" in page  # a name is never typeset
    assert "RMSE<sub>T</sub>" in page and "a<sub>0</sub>" in page


def test_every_status_is_said_in_words_of_images():
    for words in (*STATUSES, *(one for both in STATUSES.values() for one in both)):
        for foreign in ("photo", "left image", "right", "template", "epipolar"):
            assert foreign not in say(words)


def test_a_file_name_is_never_markup(pair, found, monkeypatch):
    png = lambda figure: plt.close(figure) or "png"  # noqa: E731
    monkeypatch.setattr(_registration_figures, "png", png)
    name = "<script>alert(1)</script><img src=x onerror=alert(1)>.png"
    html = report.registration.html(found, *pair, settings=LSM, about=name)
    assert "<script" not in html and "<img src=x" not in html
    assert "&lt;script&gt;alert(1)&lt;/script&gt;" in html


def test_the_page_needs_no_other_file(page):
    assert not re.findall(r'(?:src|href)="(?!data:image/png;base64,|#s\d)', page)
    assert "@import" not in page and "url(" not in page


def test_the_short_text_fits_a_terminal():
    found = images.result(status=MIXED)
    long, short = (text(found, short=one) for one in (False, True))
    assert "30 of 40 points were accepted" in long and "30 of 40" in short
    assert max(map(len, short.splitlines())) <= 88
    assert re.search("^ambiguous +4  ", long, re.MULTILINE)
    assert "- below threshold: 6 points: nothing that was" in " ".join(short.split())


def test_settings_are_those_given_and_the_defaults_of_the_others():
    given = {"refine": "parabola", "chip": 31, "number": 40}
    words = text(images.result(), settings=given)
    defaults = registration.register.__kwdefaults__
    shown = given | {"threshold": defaults["threshold"], "radius": 3}
    for name, value in shown.items():
        assert line(words, name)[0] == str(value)
    with pytest.raises(ValueError, match="settings: a name must be one of 'points', "):
        text(images.result(), settings={"windows": 31})


def test_shifts_between_pixels_are_never_called_whole():
    with pytest.raises(ValueError, match="settings must say how the shifts were"):
        text(images.result(), settings=None)


def test_a_model_of_another_registration_is_refused():
    model = registration.fit(images.result(20))
    with pytest.raises(ValueError, match="model is of 20 points, and found has 40"):
        text(images.result(), model=model)


def test_one_point_and_none_are_reported_too(pair):
    none = images.result(2, ["ambiguous", "ambiguous"])
    html = report.registration.html(none, *pair)
    assert "None of 2 points was accepted" in html and html.count("<img") == 1
    one = images.result(1, scatter=0)
    html = report.registration.html(one, *pair, settings=LSM)
    assert html.count("<img") == 4 and "1.25 px farther to the right" in html


# ------------------------------------------------------------------- the headline


def first(found, **more):
    return " ".join(text(found, short=True, **more).partition("\n\n\n")[0].split())


@pytest.mark.parametrize(
    "shift, words",
    [
        ((1.25, -0.5), "1.25 px farther to the right and 0.50 px higher than"),
        ((-2.0, 0.75), "2.00 px farther to the left and 0.75 px lower than"),
        ((0.0, 0.75), "lies 0.75 px lower than"),
    ],
)
def test_directions_are_those_of_dx_and_dy(shift, words):
    assert words in first(images.result(shift=shift, scatter=1e-4))


def test_no_shift_is_called_none():
    words = first(images.result(shift=(0.005, -0.003), scatter=0.01))
    assert "a shift of 40 points is not found" in words
    assert "noticed from about 0.02 px on" in words


def test_the_headline_never_knows_more_than_all_points_share():
    """However small their scatter; and the scatter counts where it is larger."""
    for refine, least in COMMON.items():
        sd = 1e-6 if refine else 0.289
        found = images.result(400, scatter=1e-6, sd=sd)
        of = case(found, settings={"refine": refine})
        assert of.known == pytest.approx(least, rel=1e-3)
    left = case(images.result(400, scatter=1e-6), settings=LSM | {"smooth": 0.0})
    assert left.known == pytest.approx(0.03, rel=0.01)
    found = images.result(25, scatter=0.5, sd=0.01)
    robust = 1.4826 * np.median(np.abs(found.dx - np.median(found.dx)))
    assert case(found).known >= robust / 5


def test_a_few_blunders_do_not_move_the_headline():
    found = images.result(scatter=0.005)
    found.dx[:5] += 2.5
    assert "1.25 px farther to the right" in first(found)


# ----------------------------------------------------------------------- warnings


def test_a_good_registration_is_not_warned_of():
    found = images.result()
    of = case(found, registration.fit(found))
    assert findings.findings(of) == []
    assert "Nothing to warn of." in text(images.result())


def test_shifts_that_are_spread_like_chance_are_no_shift():
    """Drawn by lot from the window within its border: the sd that is stated."""
    rng = np.random.default_rng(1)
    lot = rng.integers(-2, 3, (2, 4000)).astype(float)
    assert case(images.result()).chance == pytest.approx(lot.std(), rel=0.02)
    found = images.result(30, dx=lot[0, :30], dy=lot[1, :30])
    assert "guesses reaches 1.4 px" in said(found, "Shifts that do not agree")
    assert "No common shift was found: 30 of 30 points" in first(found)
    few = images.result(5, dx=lot[0, :5], dy=lot[1, :5])  # an affine one fits nearly
    assert said(few, "Shifts that do not agree")
    assert said(images.result(scatter=0.3), "Shifts that do not agree") == ""


def test_the_same_image_twice():
    same = {"dx": np.zeros(40), "dy": np.zeros(40), "r": np.ones(40)}
    assert "Is it the same image twice?" in said(images.result(**same), "No difference")
    assert said(images.result(shift=(0, 0)), "No difference") == ""


def test_few_points():
    status = ["accepted"] * 19 + ["ambiguous"] * 21
    words = said(images.result(40, status), "Few points")
    assert words.startswith("19 points of 40 found. Most often the reason is")
    assert "Take a larger chip" in words
    assert said(images.result(12), "Few points") == ""


def test_peaks_on_the_border_ask_for_a_larger_radius():
    title = "Peaks on the border of the search"
    words = said(images.result(40, ["accepted"] * 36 + [BORDER] * 4), title)
    assert words.startswith("4 points of 40") and "--radius 6" in words
    assert said(images.result(40, ["accepted"] * 37 + [BORDER] * 3), title) == ""


def test_a_shift_beyond_half_the_radius_asks_for_an_offset():
    title = "A shift beyond half the radius"
    words = said(images.result(shift=(1.6, -2.2)), title)
    assert "2.2 px is more than half the radius of 3 px" in words
    assert "--offset 2 -2" in words
    assert "--offset 12 5" in said(
        images.result(shift=(1.6, -2.2)), title, settings=LSM | {"offset": (10.0, 7.0)}
    )
    assert said(images.result(shift=(1.4, 0)), title) == ""


def test_changed_places_are_counted():
    title = "Places that look different"
    status = ["accepted"] * 32 + ["changed"] * 5 + ["below threshold"] * 3
    assert "8 points of 40" in said(images.result(40, status), title)
    status[-1] = "ambiguous"
    assert said(images.result(40, status), title) == ""


def test_points_in_one_part():
    points = images.result().points * 0.3
    words = said(images.result(points=points), "Points in one part of the image")
    assert "of the reference image, at the upper left" in words
    share = np.prod(0.3 * np.ptp(images.result().points, axis=0))
    share /= images.ROWS * images.COLUMNS
    stated = float(re.search(r"within (\d+) %", words)[1])
    assert stated == pytest.approx(100 * share, abs=2)


def test_a_shift_that_changes_is_seen_where_one_shift_was_fitted():
    title = "A shift that changes over the image"
    found = images.result()
    x, y = found.points.T
    turned = images.result(dx=found.dx - 0.002 * y, dy=found.dy + 0.002 * x)
    words = said(turned, title, model=registration.fit(turned))
    assert float(re.search(r"up to ([\d.]+) px", words)[1]) == pytest.approx(
        0.002 * np.ptp(x) / 2, rel=0.2
    )
    model = registration.fit(turned)
    assert model.sigma0 > 3 and not said(
        turned, "More scatter than predicted", model=model
    )
    assert said(turned, title, model=registration.fit(turned, "affine")) == ""
    far = images.result(dx=found.dx - 0.02 * y, dy=found.dy + 0.02 * x)
    model = registration.fit(far)
    assert "up to 1." in said(far, title, model=model)  # and no chance
    assert said(far, "Shifts that do not agree", model=model) == ""
    assert said(found, title, model=registration.fit(found)) == ""


def test_scatter_beyond_the_prediction_and_blunders():
    found = images.result(scatter=0.1, sd=0.02)
    words = said(found, "More scatter than predicted", model=registration.fit(found))
    stated = float(re.match(r"sigma0 is ([\d.]+):", words)[1])
    assert stated == pytest.approx(5, rel=0.25)
    found = images.result()
    found.dx[[4, 17]] += 1.5
    words = said(
        found, "Accepted points that do not fit", model=registration.fit(found)
    )
    assert words.startswith("2 points do not follow") and "4 and 17" in words


def test_whole_pixels_are_called_so():
    whole = images.result(sd=0.289)
    assert said(whole, "Whole pixels only", settings={"refine": None})
    assert said(images.result(), "Whole pixels only") == ""


def test_each_limit_is_stated_with_its_value():
    words = " ".join(findings.limits())
    for value in ("twelve", "10 %", "20 %", "0.01 px", "0.05 px", "0.29 px"):
        assert value in words


# ------------------------------------------------------------------------- drawings


@pytest.fixture
def close():
    yield
    plt.close("all")


def test_two_colours_are_grey_where_images_agree(close):
    grey = np.arange(100.0).reshape(10, 10)
    other = grey.copy()
    other[:, :5] = other[:, :5].mean()
    other = np.ma.array(other, mask=np.zeros((10, 10), bool))
    other[9, 9] = np.ma.masked
    ax, again = plot.registration.fringes(grey, {"a": grey, "b": other}, (30, 5)).axes
    red, green, blue = np.moveaxis(ax.images[0].get_array(), -1, 0)
    np.testing.assert_allclose(red, blue)
    np.testing.assert_allclose(red, green)
    np.testing.assert_array_equal(again.images[0].get_array()[9, 9], 1)
    assert ax.images[0].get_extent() == [29.5, 39.5, 14.5, 4.5]
    part = again.images[0].get_array()[:, :5]
    assert np.ptp(part[..., 0] - part[..., 1]) > 0.1


def test_green_is_the_brighter_reference_and_magenta_the_brighter_other(close):
    grey = np.tile(np.linspace(0, 1, 20), (20, 1))
    (ax,) = plot.registration.fringes(grey, {"other": grey[:, ::-1]}).axes
    colours = ax.images[0].get_array()
    np.testing.assert_array_equal(colours[5, -1], (0, 1, 0))
    np.testing.assert_array_equal(colours[5, 0], (1, 0, 1))


def test_before_and_after_show_the_part_of_each_image(pair, found, monkeypatch, close):
    """Resampled by the model, the part is what the whole would be there."""
    from pgm_lab.report import _registration_figures as figures

    model = registration.fit(found)
    down, right = 10, 20
    cut = pair[1][down:, right:]
    offset = np.array([-right, -down])
    given = LSM | {"offset": offset}
    moved = replace(model, offset=model.offset + offset)
    of = page_of._case(found, pair[0], cut, moved, None, given, "")
    shown = {}

    def noted(reference, images, corner):
        shown.update(images, reference=reference, corner=corner)
        return plt.figure()

    monkeypatch.setattr(plot.registration, "fringes", noted)
    ((_, words),) = figures.pictures("overlay", of)
    left, top = shown["corner"]
    part = np.s_[top : top + figures.PART, left : left + figures.PART]
    np.testing.assert_array_equal(shown["reference"], pair[0][part])
    before, after = shown["before"], shown["after, by the model: shift"]
    expected = np.ma.masked_all(pair[0].shape)
    expected[down:, right:] = cut
    np.testing.assert_array_equal(np.ma.getmaskarray(before), expected[part].mask)
    np.testing.assert_array_equal(before.filled(0), expected[part].filled(0))
    whole = registration.resample(cut, moved, pair[0].shape)[part]
    np.testing.assert_allclose(after.filled(0), whole.filled(0), atol=1)
    assert "1.3 px" in words


def test_arrows_are_the_shifts_and_marks_the_lost_points(pair, close):
    found = images.result(status=MIXED)
    fig = plot.registration.shifts(pair[0], found)
    (arrows,) = [one for one in fig.axes[0].collections if isinstance(one, Quiver)]
    np.testing.assert_allclose(arrows.U, found.dx[:30])
    np.testing.assert_allclose(arrows.V, found.dy[:30])
    np.testing.assert_array_equal(arrows.get_offsets(), found.points[:30])
    names = [one.get_label() for one in fig.axes[0].lines]
    assert names == ["below threshold: 6", "ambiguous: 4"]
    np.testing.assert_array_equal(fig.axes[0].lines[0].get_xydata(), found.points[34:])


def test_the_circle_holds_nine_tenths_of_the_shifts(close):
    found = images.result(400, scatter=0.2)
    whole, near = plot.registration.scatter(found, radius=3).axes
    (circle,) = [one for one in whole.patches if isinstance(one, Circle)]
    inside = np.hypot(found.dx, found.dy) <= circle.get_radius()
    assert np.mean(inside) == pytest.approx(0.9, abs=0.005)
    predicted, own = near.patches
    assert predicted.width == pytest.approx(2 * 0.02 * np.sqrt(2 * np.log(10)))
    assert own.width == pytest.approx(2 * 0.2 * np.sqrt(2 * np.log(10)), rel=0.15)
    x, y = near.lines[0].get_xydata().T
    np.testing.assert_allclose(x, found.dx - found.dx.mean())
    model = registration.fit(found)
    _, off = plot.registration.scatter(found, 3, -model.residuals).axes
    x, _ = off.lines[0].get_xdata(), off.lines[0].get_ydata()
    np.testing.assert_allclose(x, found.dx - model.parameters[0])
    assert whole.yaxis_inverted() and near.yaxis_inverted()  # rows count down


def test_the_line_of_the_prediction_has_nine_tenths_below(close):
    found = images.result(2000, scatter=0.05, sd=0.05)
    errors = np.column_stack([found.dx, found.dy]) - images.SHIFT
    by_r, by_sd = plot.registration.similarity(found, errors).axes
    dots, line = by_sd.lines
    x, y = line.get_xydata().T
    slope = y[0] / x[0]
    below = dots.get_ydata() <= slope * dots.get_xdata()
    assert below.mean() == pytest.approx(0.9, abs=0.02)
    np.testing.assert_array_equal(by_r.lines[0].get_xdata(), found.r)


@pytest.mark.parametrize("wrong", [np.zeros((3, 2)), np.full((40, 2), np.nan)])
def test_vectors_of_other_points_are_refused(pair, wrong, close):
    found = images.result()
    with pytest.raises(ValueError, match="errors must"):
        plot.registration.similarity(found, wrong)
    with pytest.raises(ValueError, match="vectors must"):
        plot.registration.shifts(pair[0], found, wrong)


def test_every_figure_says_what_it_shows(page):
    texts = re.findall(r'<img [^>]*alt="([^"]+)"', page)
    assert len(texts) == 5 and all(len(one) > 60 for one in texts)
    assert "fringes" in texts[0] and "CE90" in texts[1] and "arrow" in texts[2]
