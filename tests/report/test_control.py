"""The report of a network with control, scale bars and check points, end to end."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from pgm_lab import bundle, report
from pgm_lab.report import _figures, _findings, _misfit, _words
from tests.networks import small

SOME = ("c", "x0", "y0", "K1", "P1", "P2", "b1")
CONTROL = np.array([0, 5, 11, 17, 8])
SIGMA = np.full((5, 3), 0.05)
SIGMA[1, 2] = SIGMA[3, 0] = SIGMA[3, 1] = np.inf
SIGMA[2] = 0
FIXED, CHECK = 14, np.array([2, 3])


def adjusted(network):
    return bundle.adjust(network, SOME, tolerance=1e-9)


@pytest.fixture(scope="module")
def network():
    """Nine weighted, three held and three free coordinates, a fixed point, two bars."""
    network = small(photos=8, points=20)
    rng = np.random.default_rng(1)
    X = bundle.adjust(network, SOME).points
    given = X + 0.03 * rng.normal(size=X.shape)
    bars = [
        (1, 6, np.linalg.norm(X[1] - X[6]) + 0.02, 0.03),
        (7, 13, np.linalg.norm(X[7] - X[13]) - 0.01, 0.03),
    ]
    points = network.points.copy()
    points[FIXED] = X[FIXED]
    return replace(
        network,
        points=points,
        fixed=[FIXED],
        control=(CONTROL, given[CONTROL], SIGMA),
        check=(CHECK, given[CHECK]),
        scale_bars=bars,
        point_names=[f"P{j}" for j in range(20)],
    )


@pytest.fixture(scope="module")
def result(network):
    return adjusted(network)


def with_control(network, row, axis, error):
    index, given, sigma = network.control
    given = given.copy()
    given[row, axis] += error
    return replace(network, control=(index, given, sigma))


def with_bar(network, bar, error):
    bars = network.scale_bars.copy()
    bars[bar, 2] += error
    return replace(network, scale_bars=bars)


GREEK = {"σ": "sigma", "ω": "omega", "φ": "phi", "κ": "kappa", "τ": "tau", "ρ": "rho"}


def plain(page):
    """Undo what the page does to formulas and numbers: the text report has them so."""
    page = re.sub(
        " × 10<sup>(−?)([0-9]+)</sup>",
        lambda found: f"e{'-' if found[1] else '+'}{int(found[2]):02d}",
        page,
    )
    page = re.sub("v<sup>T</sup>P", "v'P", page)
    page = re.sub("M<sub>(.)</sub>", lambda found: f"M_{GREEK[found[1]]}", page)
    page = page.replace("<sup>", "^").replace("−", "-").replace("√(", "sqrt(")
    page = re.sub("</?su[bp]>|<caption><span>|</span></caption>", _undone, page)
    return "".join(GREEK.get(letter, letter) for letter in page)


def _undone(found):
    return {"<caption><span>": "<caption>", "</span></caption>": "</caption>"}.get(
        found[0], ""
    )


class Tables(HTMLParser):
    """The tables of a page: caption -> rows of cells, the header first."""

    def __init__(self, page):
        super().__init__()
        self.tables, self.rows, self.inside = {}, [], ""
        self.feed(page)

    def handle_starttag(self, tag, attributes):
        if tag == "tr":
            self.rows.append([])
        if tag in ("th", "td"):
            self.rows[-1].append("")
        self.inside = tag

    def handle_endtag(self, tag):
        self.inside = ""

    def handle_data(self, data):
        if self.inside == "caption":
            self.rows = self.tables.setdefault(data, [])
        elif self.inside in ("th", "td"):
            self.rows[-1][-1] += data


@pytest.fixture(autouse=True, scope="module")
def _nothing_is_drawn():
    """The numbers are tested here; tests/report/test_page.py looks at the pictures."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(_figures, "pictures", lambda *_: [])
        yield


@pytest.fixture(scope="module")
def tables(result):
    return Tables(plain(report.html(result))).tables


def rows(tables, caption):
    (found,) = [cells for name, cells in tables.items() if name.startswith(caption)]
    return np.array(found[1:])


def test_page_and_text_hold_the_same_numbers(result, tables):
    lines = report.text(result).splitlines()
    assert len(tables) == 10
    for table in tables.values():
        for cells in table:
            row = r" +".join(map(re.escape, cells))
            assert any(re.fullmatch(row, line.strip()) for line in lines), cells


def test_each_control_coordinate_has_its_difference(result, network, tables):
    """Those that are held have none; those left free have one, as check points do."""
    shown = rows(tables, "Control points")
    assert list(shown[:, 0]) == ["P0", "P5", "P11", "P17", "P8"]
    held = SIGMA == 0
    assert np.all((shown[:, 1:4] == "held") == held)
    difference = result.points[CONTROL] - network.control[1]
    # two digits of a usual one, 0.03: half a unit of the fourth decimal
    np.testing.assert_allclose(
        shown[:, 1:4][~held].astype(float), difference[~held], atol=0.51e-4
    )
    check = rows(tables, "Check points")
    difference = result.points[CHECK] - network.check[1]
    np.testing.assert_allclose(check[:, 1:].astype(float), difference, atol=0.51e-4)


def test_r_is_the_part_of_an_error_that_the_residual_shows(result, network, tables):
    """Each value is made wrong by 0.01 in turn, and the network adjusted again."""
    shown, error = rows(tables, "Control points"), 0.01
    weighted = (SIGMA > 0) & np.isfinite(SIGMA)
    assert np.all((shown[:, 4:10] == "-") == np.hstack([~weighted] * 2))
    for row, axis in np.argwhere(weighted):
        there = adjusted(with_control(network, row, axis, error))
        v = result.control_residuals[row, axis]
        r = (v - there.control_residuals[row, axis]) / error
        assert float(shown[row, 4 + axis]) == pytest.approx(r, abs=0.0055)
        w = v / (SIGMA[row, axis] * result.sigma0 * np.sqrt(r))
        assert float(shown[row, 7 + axis]) == pytest.approx(w, abs=0.055)
    shown = rows(tables, "Scale bars")
    assert list(shown[:, 0]) == ["P1 to P6", "P7 to P13"]
    for bar in range(2):
        there = adjusted(with_bar(network, bar, error))
        v = result.scale_bar_residuals[bar]
        r = (v - there.scale_bar_residuals[bar]) / error
        a, b, length, sigma = network.scale_bars[bar]
        distance = np.linalg.norm(result.points[int(a)] - result.points[int(b)])
        w = (distance - length) / (sigma * result.sigma0 * np.sqrt(r))
        expected = length, distance - length, r, w
        missed = np.abs(shown[bar, 1:].astype(float) - expected)
        assert np.all(missed <= [5.1e-4, 5.1e-4, 0.0055, 0.055])


def test_the_summary_counts_weighted_coordinates_and_nothing_else(result):
    """320 + 9 + 2 observations; 7 + 48 + 60 unknowns without the six that are held."""
    said = _words.summary(result)
    assert "320 image coordinates, 9 control coordinates and 2 scale bars for" in said
    assert "for 109 unknowns, redundancy 222." in said
    assert result.redundancy == 222
    assert "the observations are as good as stated" in said


def test_points_that_are_held_have_no_standard_deviation(result, tables):
    shown = rows(tables, "Object points")
    for j, row in enumerate(shown):
        held = j in (11, FIXED)
        assert np.all((row[[2, 4, 6]] == "held") == held)
        np.testing.assert_allclose(
            row[[1, 3, 5]].astype(float), result.points[j], atol=0.51e-3
        )


def test_without_weighted_control_there_is_nothing_to_test(network):
    index, given, sigma = network.control
    held = replace(
        network, control=(index, given, np.where(sigma < 1, 0, sigma)), scale_bars=()
    )
    found = adjusted(held)
    text = report.text(found)
    assert "Control points: adjusted - given, in object units\n" in text
    assert "r X" not in text and "Scale bars" not in text
    assert "so the image coordinates are" in re.sub(r"\s+", " ", text)
    assert report.html(found)
    none = replace(held, control=None, check=None, fixed=())
    assert "Control and checks" not in report.text(adjusted(none))


def test_control_that_nothing_checks_has_a_redundancy_of_zero(network):
    """Seven coordinates carry the datum, and their residuals are zero whatever."""
    sigma = np.full((3, 3), np.inf)
    sigma[0] = sigma[1] = sigma[2, 2] = 0.05
    given = network.control[1][[0, 1, 3]]
    least = replace(
        network, fixed=(), scale_bars=(), control=(CONTROL[[0, 1, 3]], given, sigma)
    )
    found = adjusted(least)
    shown = rows(Tables(plain(report.html(found))).tables, "Control points")
    assert set(shown[:, 4:7].ravel()) == {"0.00", "-"}
    assert set(shown[:, 7:].ravel()) == {"-"}
    assert control_finding(found) is None
    no_more = "There are no more control coordinates than the datum needs"
    assert no_more in _words.datum(found)
    for changes, said in (
        ({"control": None, "fixed": [0, 5, 11]}, False),
        ({"fixed": [FIXED], "control": (CONTROL[:2], given[:2], sigma[1:])}, True),
        ({"scale_bars": network.scale_bars}, False),  # they check the scale
        (
            {
                "scale_bars": network.scale_bars,
                "fixed": [FIXED],
                "control": (
                    CONTROL[:2],
                    given[:2],
                    [[0.1, 0.1, np.inf], 2 * [np.inf] + [0.1]],
                ),
            },
            True,
        ),
    ):
        other = replace(found, network=replace(least, **changes))
        assert (no_more in _words.datum(other)) == said


def control_finding(result):
    return dict(_findings.findings(result)).get("Control that does not fit")


def test_a_wrong_control_point_comes_before_the_rays(network):
    """30 sigma in Y of P8: the warning, sigma0, the suspects and snooping say so."""
    wrong = with_control(network, 4, 1, 1.5)
    found = bundle.snoop(wrong, SOME)
    assert found.removed == ()
    said = control_finding(found.result)
    w = found.result.control_standardized
    assert np.unravel_index(np.argmax(np.abs(w)), w.shape) == (4, 1)
    assert f"Y of control point P8 (tau = {w[4, 1]:.1f})" in said
    assert "Look at control first: a wrong control point or scale bar spoils" in said
    warnings = dict(_findings.findings(found.result))
    sigma0 = warnings["Stated standard deviations"]
    assert sigma0.endswith("or a control point or a scale bar is wrong.")
    text = re.sub(r"\s+", " ", report.text(found, short=True))
    assert "rejected no observation: control point P8 has the largest residual" in text
    assert found.stopped in re.sub(r"\s+", " ", report.html(found))
    rays = found.result.standardized.copy()
    rays[3] = 0.9 * np.abs(w).max()
    suspects = replace(found.result, standardized=rays)
    said = dict(_findings.findings(suspects))["Suspected blunders"]
    assert said.endswith(
        "Control comes first: once it is right, good rays among these fit."
    )


def test_a_wrong_scale_bar_is_named_by_its_ends(network):
    found = bundle.snoop(with_bar(network, 1, -2.0), SOME)
    w = found.result.scale_bar_standardized[1]
    said = control_finding(found.result)
    assert f"the scale bar P7 to P13 (tau = {w:.1f})" in said and w > 0
    assert "scale bar 2 has the largest residual" in found.stopped


def test_a_blunder_of_a_ray_comes_before_good_control(network, result):
    """What has the larger residual is looked at first."""
    w = np.zeros_like(result.control_standardized)
    w[0, 2] = 5.0
    for of_ray, first in ((4.9, True), (5.1, False)):
        rays = np.zeros_like(result.standardized)
        rays[7, 1] = -of_ray
        both = replace(result, standardized=rays, control_standardized=w)
        assert ("Look at control first" in control_finding(both)) == first
        assert ("But a ray has a larger one" in control_finding(both)) != first
        (said,) = [
            f.words for f in _findings.findings(both) if f.title.startswith("Suspected")
        ]
        assert ("Control comes first" in said) == first


@pytest.mark.parametrize("size, warned", [(0.99, False), (1.01, True)])
@pytest.mark.parametrize("kind", ["control_standardized", "scale_bar_standardized"])
def test_the_limit_of_control_is_that_of_the_rays(result, kind, size, warned):
    limit = bundle.critical_value(result)
    w = {
        name: np.zeros_like(getattr(result, name))
        for name in ("standardized", "control_standardized", "scale_bar_standardized")
    }
    w[kind].flat[1] = -size * limit
    assert (control_finding(replace(result, **w)) is not None) == warned


def test_many_wrong_coordinates_are_told_the_largest_first(result):
    w = np.zeros_like(result.control_standardized)
    w[0, 0], w[4, 2] = 4.0, -6.0
    bars = np.array([5.0, 0.0])
    many = replace(result, control_standardized=w, scale_bar_standardized=bars)
    said = control_finding(many)
    assert said.startswith(
        "The standardised residuals of Z of control point P8 (tau = -6.0), the scale"
        " bar P1 to P6 (tau = 5.0) and X of control point P0 (tau = 4.0) are above"
    )


@pytest.mark.parametrize("kind", ["control_standardized", "scale_bar_standardized"])
def test_a_gross_error_of_control_makes_sigma0_as_large_as_one_of_a_ray(result, kind):
    """Nothing is said of the parameters before it is corrected."""
    calm = replace(
        result,
        sigma0=2.5,
        standardized=np.zeros_like(result.standardized),
        control_standardized=np.zeros_like(result.control_standardized),
        scale_bar_standardized=np.zeros_like(result.scale_bar_standardized),
    )
    assert not _misfit.gross(calm)
    w = getattr(calm, kind).copy()
    w.flat[0] = 6.0
    assert _misfit.gross(replace(calm, **{kind: w}))


def test_sigma0_names_only_what_the_network_has(network, result):
    def cause(**changes):
        worse = replace(result, network=replace(network, **changes), sigma0=3.0)
        return dict(_findings.findings(worse))["Stated standard deviations"]

    control = {"scale_bars": ()}
    bars = {"control": None, "fixed": ()}
    quiet = {
        "control_standardized": np.zeros((0, 3)),
        "scale_bar_standardized": np.zeros(0),
    }
    result = replace(result, **quiet)
    assert cause(**control).endswith("not estimated, or a control point is wrong.")
    assert cause(**bars).endswith("not estimated, or a scale bar is wrong.")
    assert cause(control=None, scale_bars=()).endswith("or a control point is wrong.")
    assert cause(**bars, scale_bars=()).endswith("that was not estimated.")
    assert "The image coordinates are worse" in cause(**bars, scale_bars=())


def test_scale_bars_alone_give_the_scale_of_a_free_network(network):
    bars = replace(network, control=None, check=None, fixed=())
    for free in (bars, replace(bars, scale_bars=())):
        words = _words.datum(bundle.adjust(free, SOME))
        bar = len(free.scale_bars) > 0
        assert ("Origin and directions are those of" in words) == bar
        assert ("Origin, directions and scale are those of" in words) != bar
        assert ("The scale bars give the scale." in words) == bar


def test_observations_without_any_error_can_be_reported(result):
    """Computed data: sigma0 and all standard deviations are zero."""
    kinds = "residuals", "standardized"
    names = [
        *kinds,
        *(f"{what}_{k}" for what in ("control", "scale_bar") for k in kinds),
    ]
    names += ["covariance", "covariance_points"]
    nothing = {name: np.zeros_like(getattr(result, name)) for name in names}
    exact = replace(result, sigma0=0.0, **nothing)
    with np.errstate(invalid="ignore"):  # correlations of what has no sd
        text, page = report.text(exact), report.html(exact)
    assert "sigma0 is 0, as only computed observations fit without" in text
    shown = [text, *sum(sum(Tables(page).tables.values(), []), [])]
    assert not any("nan" in words or "inf " in words for words in shown)
