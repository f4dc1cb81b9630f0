"""The report of a bundle adjustment: its numbers, its sentences, and its warnings."""

import re
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import pytest
from scipy.stats import chi2

from pgm_lab import _rounding, bundle, plot, report
from pgm_lab.camera import PARAMETERS
from pgm_lab.report import _figures, _tables, network
from pgm_lab.report.network import Case
from tests.networks import real, small
from tests.report.pages import Page, joined, plain


@pytest.fixture(scope="module")
def real_network():
    """The network of 2013 with ids that cannot be taken for indices."""
    return replace(
        real(),
        photo_names=[100 + i for i in range(9)],
        point_names=[5000 - 7 * j for j in range(50)],
    )


@pytest.fixture(scope="module")
def result(real_network):
    return bundle.adjust(real_network)


@pytest.fixture(scope="module")
def quiet(result):
    """A result with nothing to warn of."""
    return replace(
        result,
        sigma0=1.0,
        standardized=np.zeros_like(result.standardized),
        covariance=np.diag(np.full(len(result.names), 1e-30)),
    )


@pytest.fixture(scope="module")
def without_redundancy(real_network):
    """Five points in two photos, and no more."""
    one = real_network
    rays = (one.photo < 2) & (one.point < 5)
    measured = one.photo[rays], one.point[rays], one.xy[rays]
    few = bundle.Network(one.cameras, one.exteriors[:2], one.points[:5], *measured)
    return bundle.adjust(few, ())


def table(result, caption):
    """Return the header and rows of the table whose caption begins so."""
    every = [
        t for part in network._case(result).sections("", False) for t in part.tables
    ]
    (found,) = [t for t in every if t.caption.startswith(caption)]
    return found.header, np.array(found.rows)


def findings(result):
    return dict(Case(result).findings)


def summary(result):
    return network._case(result).sections("", True)[0].paragraphs[0]


def datum(result):
    (part,) = [
        s for s in network._case(result).sections("", True) if s.title == "Datum"
    ]
    return part.paragraphs[0]


# --- Numbers ---


def test_each_number_is_the_result_rounded_and_no_digit_more(result):
    """Half a unit of the last digit is what rounding may change."""
    radians = np.hstack([result.exteriors, result.sd_exteriors])
    order = [0, 3, 1, 4, 2, 5]  # value, sd, value, sd, ...
    points = np.hstack([result.points, result.sd_points])
    um = 1e3 * result.residuals
    by_point = [np.sqrt(np.mean(um[result.network.point == j] ** 2)) for j in range(50)]
    centres, angles = [0, 6, 1, 7, 2, 8], [3, 9, 4, 10, 5, 11]
    for caption, columns, expected in (
        ("Object points", slice(1, 7), points[:, order]),
        ("Object points", 8, by_point),
        ("Projection centres", slice(1, 7), radians[:, centres]),
        ("Angles of the photos, in radians", slice(1, 7), radians[:, angles]),
        ("Angles of the photos, in deg", slice(1, 7), np.degrees(radians)[:, angles]),
    ):
        shown = table(result, caption)[1][:, columns]
        decimals = np.vectorize(lambda cell: len(cell.partition(".")[2]))(shown)
        wrong = np.abs(shown.astype(float) - expected)
        assert np.all(wrong <= 0.501 * 10.0**-decimals), caption
    # A usual standard deviation has two digits, the value as many decimals
    _, rows = table(result, "Object points")
    for value, sd in ((1, 2), (3, 4), (5, 6)):
        digits = np.median([int(re.sub(r"\D", "", cell)) for cell in rows[:, sd]])
        assert 10 <= digits < 200
        assert len({len(cell.partition(".")[2]) for cell in rows[:, value]}) == 1


def test_the_table_of_the_camera_holds_value_sd_and_test(result, real_network):
    _, rows = table(result, "Interior orientation")
    assert list(rows[:, 0]) == list(PARAMETERS)
    np.testing.assert_allclose(rows[:, 1].astype(float), result.interior, rtol=0.05)
    np.testing.assert_allclose(rows[:, 3].astype(float), result.sd_interior, rtol=0.05)
    tests = {one.name: one for one in bundle.significance(result)}
    for row in rows[1:]:
        one = tests[row[0]]
        assert float(row[4]) == pytest.approx(one.value / one.sd, abs=0.051)
        assert row[6] == ("yes" if one.significant else "no")
        assert float(row[7]) == pytest.approx(1e3 * one.effect, rel=0.05)
    _, rows = table(bundle.adjust(real_network, ("c",)), "Interior orientation")
    assert list(rows[:, 3] == "held") == [False] + 9 * [True]


def test_the_lens_is_tabulated_up_to_the_outermost_point(result):
    _, rows = table(result, "Lens")
    lens, xy = result.cameras[0], result.network.xy
    outermost = np.hypot(*(xy - (lens.x0, lens.y0)).T).max()
    r, radial = rows[:, :2].astype(float).T
    assert r[-1] == pytest.approx(outermost, abs=0.006)
    assert np.all(np.diff(r) > 0) and 4 <= len(r) <= 13
    expected = 1e3 * (lens.K1 * r**3 + lens.K2 * r**5 + lens.K3 * r**7)
    np.testing.assert_allclose(radial, expected, atol=0.02)  # r and radial are rounded


def test_the_fit_of_a_photo_is_that_of_its_own_rays(result):
    one, (_, rows) = result.network, table(result, "Fit of the photos")
    for i, row in enumerate(rows):
        own = one.photo == i
        v, w = 1e3 * result.residuals[own], np.abs(result.standardized[own])
        assert row[0] == str(100 + i) and int(row[1]) == np.sum(own)
        r = result.redundancy_numbers[own].mean()
        expected = [*np.sqrt(np.mean(v**2, axis=0)), r, w.max()]
        wrong = np.abs(row[2:6].astype(float) - expected)
        assert np.all(wrong <= [0.0051, 0.0051, 0.0051, 0.051])
        assert row[6] == str(one.point_names[one.point[own][w.max(axis=1).argmax()]])


def test_suspects_come_with_the_ids_of_the_input_the_largest_first(result):
    """Point 29 in photo 6 of the source is the largest: 28 and 5 counted from 0."""
    _, rows = table(result, "Suspected blunders")
    assert list(rows[0, :2]) == [str(5000 - 7 * 28), "105"]
    largest = np.abs(rows[:, 4:6].astype(float)).max(axis=1)
    assert np.all(np.diff(largest) <= 0)
    count = np.sum(np.abs(result.standardized).max(1) > bundle.critical_value(result))
    assert len(rows) == count
    assert f"point {5000 - 7 * 28} in photo 105" in report.text(result, short=True)
    # Only the largest of many are listed
    w = np.full_like(result.standardized, 5.0)
    w[11] = 9.0
    _, rows = table(replace(result, standardized=w), "Suspected blunders")
    assert len(rows) == _tables.MAX_SUSPECTS
    assert rows[0, 0] == str(result.network.point_names[result.network.point[11]])


def test_without_redundancy_no_number_is_invented(without_redundancy, monkeypatch):
    assert without_redundancy.redundancy == 0
    text = report.text(without_redundancy)
    assert "nan" not in text and "inf" not in text.replace("information", "")
    _, rows = table(without_redundancy, "Object points")
    assert set(rows[:, [2, 4, 6, 9]].ravel()) == {"-"}
    monkeypatch.setattr(_figures, "png", lambda figure: plt.close(figure) or "png")
    page = Page(report.html(without_redundancy))
    assert len(page.all("img")) == 2  # there is no precision to draw


# --- The summary ---


@pytest.mark.parametrize(
    "sigma0, words",
    [
        (1.06, "as good as stated"),
        (0.8, "about 20 % better than stated"),
        (1.5, "about 50 % worse than stated"),
        (0.4, "about 2.5 times better than stated"),
        (250.0, "about 250 times worse than stated"),
        (2870.4, "sigma0 is 2870, so the image coordinates are about 2870 times worse"),
        (1e-4, "about 10000 times better than stated"),
    ],
)
def test_sigma0_in_words(result, sigma0, words):
    assert words in summary(replace(result, sigma0=sigma0))


def test_sigma0_is_compared_with_what_was_known_before(result):
    known = replace(result, sigma0=0.35, sigma0_prior=0.35)
    assert "as good as stated, 0.35 µm in place of 0.35 µm" in summary(known)
    assert "Stated standard deviations" not in findings(known)


def test_the_summary_counts_what_the_redundancy_is_made_of(result, quiet):
    assert "900 image coordinates and 7 inner constraints for 214" in summary(result)
    assert result.redundancy == 900 + 7 - 214
    # Of nine one is held, one free: neither is an observation; one unknown less
    sigma = np.full((3, 3), 0.05)
    sigma[0, 0], sigma[1, 1] = 0, np.inf
    control = [0, 9, 30], quiet.network.points[[0, 9, 30]], sigma
    weighted = replace(quiet.network, control=control)
    case = Case(replace(quiet, network=weighted, redundancy=694))
    assert case.observed == ["900 image coordinates", "7 control coordinates"]
    assert case.unknowns == 213


def test_snooping_is_told_with_what_it_rejected(real_network):
    found = bundle.snoop(real_network)
    text = joined(report.text(found))
    assert f"rejected {len(found.removed)} rays, one at a time" in text
    header, rows = table(found, "Rays rejected")
    assert list(header[3:5]) == ["tau x", "tau y"]
    shown = [(*row[1:3], row[7]) for row in rows.tolist()]
    told = [(str(x.point), str(x.photo), f"{x.sigma0:.3f}") for x in found.removed]
    assert shown == told
    # sigma0 is what it was with the ray, and without those before it
    before = bundle.adjust(real_network)
    assert found.removed[0].sigma0 == before.sigma0
    again = bundle.adjust(real_network.without([found.removed[0].ray]))
    assert found.removed[1].sigma0 == pytest.approx(again.sigma0, rel=1e-9)
    clean = bundle.snoop(found.result.network, most=0)
    assert "rejected no observation" in report.text(clean)


def test_the_report_says_which_test_its_residuals_are_for_and_whence_its_limit(result):
    """Pope's tau without a stated sigma0, else Baarda's w: in words and all tables."""
    stated = bundle.adjust(result.network, sigma0_prior=0.3)
    for found, name, others, said in (
        (result, "tau", r"\|w\||\bw\b", "3.28 (Pope's tau, with the estimated sigma0,"),
        (stated, "w", "tau", "3.29 (Baarda's w, with the stated sigma0; one false"),
    ):
        text = report.text(found)
        assert said in joined(text) and not re.search(others, text)
        for head in (f"largest |{name}|", f"{name} x  {name} y"):
            assert head in re.sub(" {2,}", "  ", text)
    assert "tau (Pope's, with the sigma0 estimated" in joined(report.text(result))
    assert "w (Baarda's, with the sigma0 stated before" in joined(report.text(stated))
    assert "redundancy 693; one false" in joined(report.text(result))


# --- Warnings, on both sides of their limits ---


def one(values, value, at=7):
    values = values.copy()
    values[at] = value
    return values


def correlated(r, i=0, j=1):
    covariance = r.covariance.copy()
    covariance[i, j] = covariance[j, i] = 0.95e-30
    return replace(r, covariance=covariance)


def uncertain(r, times):
    """The projection centre of the third photo, in all three directions."""
    covariance = r.covariance.copy()
    centre = 10 + 6 * 2 + np.arange(3)
    covariance[centre, centre] *= times**2
    return replace(r, covariance=covariance)


def sigma0_at(r, below, prior=None):
    """sigma0 with so much probability below it."""
    sigma0 = np.sqrt(chi2.ppf(below, r.redundancy) / r.redundancy)
    return replace(r, sigma0=(prior or 1.0) * sigma0, sigma0_prior=prior)


def two_rays(r, sigma=None):
    """Only two rays to the fourth point, of which perhaps some coordinates are held."""
    net = r.network
    others = np.flatnonzero((net.point == 3) & (net.photo > 1))
    kept = np.delete(np.arange(len(net.xy)), others)
    names = "residuals", "standardized", "redundancy_numbers"
    few = {name: getattr(r, name)[kept] for name in names}
    net = net.without(others)
    if sigma is not None:
        net = replace(net, control=([3], net.points[[3]], [sigma]))
        few["control_standardized"] = np.zeros((1, 3))
    return replace(r, network=net, **few)


def few_rays(r, number):
    net = r.network
    few = np.flatnonzero((net.photo == 8) & (net.point >= number))
    return replace(r, network=net.without(few))


def with_r(r, least):
    numbers = one(r.redundancy_numbers, least, (7, 1))
    return replace(r, redundancy_numbers=numbers)


def with_tiny_P1(r):
    return replace(r, cameras=(replace(r.cameras[0], P1=1e-16),))


STATED, WEAK = "Stated standard deviations", "Weak photos"
HARDLY, TWO = "Hardly controlled observations", "Points with two rays"
WARNED = [
    (None, lambda r: r),
    ("No solution", lambda r: replace(r, status="diverged")),
    ("No redundancy", lambda r: replace(r, redundancy=0, sigma0=np.nan)),
    ("Behind the camera", lambda r: replace(r, points=one(r.points, (0, -9000, 0)))),
    ("Suspected blunders", lambda r: replace(r, standardized=one(r.standardized, 3.4))),
    ("Insignificant parameters", with_tiny_P1),
    ("Correlations above 0.9", correlated),
    (STATED, lambda r: sigma0_at(r, 0.024)),
    (None, lambda r: sigma0_at(r, 0.026)),
    (None, lambda r: sigma0_at(r, 0.974)),
    (STATED, lambda r: sigma0_at(r, 0.976)),
    (STATED, lambda r: sigma0_at(r, 0.024, 0.2)),
    (None, lambda r: sigma0_at(r, 0.026, 0.2)),
    (None, lambda r: sigma0_at(r, 0.974, 0.2)),
    (STATED, lambda r: sigma0_at(r, 0.976, 0.2)),
    (HARDLY, lambda r: with_r(r, 0.099)),
    (None, lambda r: with_r(r, 0.101)),
    (WEAK, lambda r: uncertain(r, 3.05)),
    (None, lambda r: uncertain(r, 2.95)),
    (TWO, two_rays),
    (None, lambda r: two_rays(r, (0, 0, 0))),
    (TWO, lambda r: two_rays(r, (0, 0, 1))),
    (TWO, lambda r: two_rays(r, (0, np.inf, 0))),
    (TWO, lambda r: two_rays(r, (1, 1, 1))),
]


@pytest.mark.parametrize("title, change", WARNED)
def test_each_warning_comes_with_its_cause_and_alone(quiet, title, change):
    assert list(findings(change(quiet))) == ([title] if title else [])


def test_weak_photos_are_named_with_their_rays(quiet):
    assert list(Case(uncertain(quiet, 3.05)).weak_photos) == [2]
    assert list(Case(few_rays(quiet, 6)).weak_photos) == []
    assert list(Case(few_rays(quiet, 5)).weak_photos) == [8]
    assert findings(few_rays(quiet, 5))[WEAK].startswith("108 (5 rays): fewer than six")


@pytest.mark.parametrize("number, chance", [(1, True), (3, True), (4, False)])
def test_three_of_900_are_chance_and_four_are_not(quiet, number, chance):
    """One in a thousand: more than three of 900 happen once in 75 networks."""
    w = one(quiet.standardized, 3.4, (slice(number), 0))
    said = findings(replace(quiet, standardized=w))["Suspected blunders"]
    assert "where chance alone gives about 0.9" in said
    assert ("no more than chance" in said) == chance
    assert ("Look at the largest first" in said) != chance


PAIRS = {
    "Within the camera: c with x0 (0.950)": [(0, 1)],
    "Between camera and photos: 2 pairs, led by": [(0, 10), (2, 17)],
    "Between photos: one pair, led by": [(12, 20)],
}


@pytest.mark.parametrize("shown", [[0], [1], [2], [0, 1], [1, 2], [0, 1, 2]])
def test_each_kind_of_correlation_is_told_and_no_other(quiet, shown):
    """Of parameters of the camera, of these and photos, and of photos alone."""
    found = quiet
    for k in shown:
        for pair in list(PAIRS.values())[k]:
            found = correlated(found, *pair)
    words = findings(found)["Correlations above 0.9"]
    for k, (head, pairs) in enumerate(PAIRS.items()):
        assert (head in words) == (k in shown)
        first, other = (quiet.names[i] for i in pairs[0])
        assert (f"{first} with {other} (0.950)" in words) == (k in shown)


# --- sigma0, and blunders before parameters ---


def blundered(net, size, ray=20):
    return replace(net, xy=one(net.xy, net.xy[ray, 0] + size, (ray, 0)))


@pytest.mark.parametrize("prior", [None, 1.0])
def test_standard_deviations_in_micrometres_are_asked_about(real_network, prior):
    """1 µm given as 1 mm: sigma0 is 1000 times too small, and no number hides it."""
    wrong = replace(real_network, sigma=1000 * real_network.sigma)
    found = bundle.adjust(wrong, sigma0_prior=prior)
    said = findings(found)[STATED]
    assert "are the standard deviations in µm? Those of" in said
    assert "sigma0 = 0.000349 is not 1" in said
    text = joined(report.text(found, short=True))
    assert "about 2870 times better" in text
    assert not re.search(r"\de[-+]\d+ (µm|times)", text)
    few = replace(found, sigma0=0.011, sigma0_prior=prior)
    assert "in µm?" not in findings(few)[STATED]


@pytest.mark.parametrize("prior", [None, 1.0])
def test_a_gross_blunder_comes_before_the_parameters(real_network, prior):
    """It makes sigma0 and so all standard deviations large; other causes do not."""

    def said(net, **changes):
        found = replace(bundle.adjust(net, sigma0_prior=prior), **changes)
        return findings(found)["Insignificant parameters"]

    for size in (0.1, 0.5, 2.0):
        words = said(blundered(real_network, size))
        assert words.startswith("First the blunders: as long as they make sigma0")
        assert "Leave out" not in words and "e+" not in words
    assert "Leave out one at a time" in said(real_network)
    # Stated thirty times too well, all of them: the parameters can be judged
    exact = replace(real_network, sigma=real_network.sigma / 30)
    found = bundle.adjust(exact, sigma0_prior=prior)
    unit = found.sigma0 / prior if prior else 1.0  # a usual standardised residual
    even = np.clip(found.standardized, -2.5 * unit, 2.5 * unit)
    assert "Leave out" in said(exact, standardized=even)


# --- Interchanged points ---


@pytest.mark.parametrize("seed", range(4))
def test_two_interchanged_points_are_recognised(real_network, seed):
    """Neighbours of one photo: each lies where the other should be."""
    net, rng = real_network, np.random.default_rng(seed)
    photo = rng.integers(9)
    own = np.flatnonzero(net.photo == photo)
    a = rng.choice(own)
    b = own[np.argsort(np.linalg.norm(net.xy[own] - net.xy[a], axis=1))[1]]
    found = bundle.adjust(replace(net, xy=one(net.xy, net.xy[[b, a]], [a, b])))
    assert Case(found).interchanged in ([(a, b)], [(b, a)])
    names = {net.point_names[net.point[k]] for k in (a, b)}
    pattern = r"Interchanged, it seems: points (\d+) and (\d+) in photo (\d+)\."
    said = re.search(pattern, findings(found)["Suspected blunders"])
    assert {int(said[1]), int(said[2])} == names and int(said[3]) == 100 + photo


def with_errors(result, *pairs):
    """Errors of pairs of rays: (ray, ray), (error, error), size of the residuals."""
    v, w = np.zeros_like(result.residuals), np.zeros_like(result.standardized)
    for rays, errors, size in pairs:
        rays = list(rays)
        v[rays] = -result.redundancy_numbers[rays] * np.array(errors)
        w[rays] = size
    return replace(result, residuals=v, standardized=w)


def test_other_blunders_are_no_interchange(result):
    """In one photo, in two photos, in the same direction, or of another size."""
    net, (a, b, elsewhere) = result.network, (20, 30, 70)
    assert net.photo[a] == net.photo[b] != net.photo[elsewhere]
    d, far = net.xy[a] - net.xy[b], net.xy[a] - net.xy[elsewhere]
    for at, errors, expected in (
        ((a, b), (d, -d), [(a, b)]),
        ((a, b), (d, d), []),
        ((a, b), (3 * d, -3 * d), []),
        ((a, b), (d, 0.1 * d), []),
        ((a, b), (-d, d), []),
        ((a, elsewhere), (far, -far), []),
    ):
        found = with_errors(result, (at, errors, 9.0))
        assert Case(found).interchanged == expected
    assert "Interchanged" not in report.text(result)


# --- Control, check points and scale bars, end to end ---

SOME = ("c", "x0", "y0", "K1", "P1", "P2", "b1")
CONTROL = np.array([0, 5, 11, 17, 8])
SIGMA = np.full((5, 3), 0.05)
SIGMA[1, 2] = SIGMA[3, 0] = SIGMA[3, 1] = np.inf
SIGMA[2] = 0
FIXED, CHECK = 14, np.array([2, 3])
KINDS = "control_standardized", "scale_bar_standardized"


def adjusted(net):
    return bundle.adjust(net, SOME, tolerance=1e-9)


@pytest.fixture(scope="module")
def controlled():
    """Nine weighted, three held and three free coordinates, a fixed point, two bars."""
    net = small(photos=8, points=20)
    rng = np.random.default_rng(1)
    X = bundle.adjust(net, SOME).points
    given = X + 0.03 * rng.normal(size=X.shape)
    bars = [
        (1, 6, np.linalg.norm(X[1] - X[6]) + 0.02, 0.03),
        (7, 13, np.linalg.norm(X[7] - X[13]) - 0.01, 0.03),
    ]
    return replace(
        net,
        points=one(net.points, X[FIXED], FIXED),
        fixed=[FIXED],
        control=(CONTROL, given[CONTROL], SIGMA),
        check=(CHECK, given[CHECK]),
        scale_bars=bars,
        point_names=[f"P{j}" for j in range(20)],
    )


@pytest.fixture(scope="module")
def of_control(controlled):
    return adjusted(controlled)


def with_control(net, row, axis, error):
    index, given, sigma = net.control
    return replace(
        net, control=(index, one(given, given[row, axis] + error, (row, axis)), sigma)
    )


def with_bar(net, bar, error):
    bars = net.scale_bars
    return replace(net, scale_bars=one(bars, bars[bar, 2] + error, (bar, 2)))


def test_page_and_text_hold_the_same_numbers(of_control, monkeypatch):
    monkeypatch.setattr(_figures, "png", lambda figure: plt.close(figure) or "png")
    lines = report.text(of_control).splitlines()
    tables = Page(plain(report.html(of_control))).tables
    assert len(tables) == 10
    for cells in sum(tables.values(), []):
        row = r" +".join(map(re.escape, cells))
        assert any(re.fullmatch(row, line.strip()) for line in lines), cells


def test_each_control_coordinate_has_its_difference(of_control, controlled):
    """Those that are held have none; those left free have one, as check points do."""
    _, shown = table(of_control, "Control points")
    assert list(shown[:, 0]) == ["P0", "P5", "P11", "P17", "P8"]
    held = SIGMA == 0
    assert np.all((shown[:, 1:4] == "held") == held)
    difference = of_control.points[CONTROL] - controlled.control[1]
    # two digits of a usual one, 0.03: half a unit of the fourth decimal
    np.testing.assert_allclose(
        shown[:, 1:4][~held].astype(float), difference[~held], atol=0.51e-4
    )
    _, check = table(of_control, "Check points")
    difference = of_control.points[CHECK] - controlled.check[1]
    np.testing.assert_allclose(check[:, 1:].astype(float), difference, atol=0.51e-4)
    for j, row in enumerate(table(of_control, "Object points")[1]):
        assert np.all((row[[2, 4, 6]] == "held") == (j in (11, FIXED)))
        shown = row[[1, 3, 5]].astype(float)
        np.testing.assert_allclose(shown, of_control.points[j], atol=0.51e-3)


def test_r_is_the_part_of_an_error_that_the_residual_shows(of_control, controlled):
    """Each value is made wrong by 0.01 in turn, and the network adjusted again."""
    (_, shown), error = table(of_control, "Control points"), 0.01
    weighted = (SIGMA > 0) & np.isfinite(SIGMA)
    assert np.all((shown[:, 4:10] == "-") == np.hstack([~weighted] * 2))
    for row, axis in np.argwhere(weighted):
        there = adjusted(with_control(controlled, row, axis, error))
        v = of_control.control_residuals[row, axis]
        r = (v - there.control_residuals[row, axis]) / error
        assert float(shown[row, 4 + axis]) == pytest.approx(r, abs=0.0055)
        w = v / (SIGMA[row, axis] * of_control.sigma0 * np.sqrt(r))
        assert float(shown[row, 7 + axis]) == pytest.approx(w, abs=0.055)
    _, shown = table(of_control, "Scale bars")
    assert list(shown[:, 0]) == ["P1 to P6", "P7 to P13"]
    for bar in range(2):
        there = adjusted(with_bar(controlled, bar, error))
        v = of_control.scale_bar_residuals[bar]
        r = (v - there.scale_bar_residuals[bar]) / error
        a, b, length, sigma = controlled.scale_bars[bar]
        ends = of_control.points[[int(a), int(b)]]
        distance = np.linalg.norm(ends[0] - ends[1])
        w = (distance - length) / (sigma * of_control.sigma0 * np.sqrt(r))
        expected = length, distance - length, r, w
        missed = np.abs(shown[bar, 1:].astype(float) - expected)
        assert np.all(missed <= [5.1e-4, 5.1e-4, 0.0055, 0.055])


def test_the_summary_counts_weighted_coordinates_and_nothing_else(of_control):
    """320 + 9 + 2 observations; 7 + 48 + 60 unknowns without the six that are held."""
    said = summary(of_control)
    assert "320 image coordinates, 9 control coordinates and 2 scale bars for" in said
    assert "for 109 unknowns, redundancy 222." in said
    assert of_control.redundancy == 222
    assert "the observations are as good as stated" in said
    assert "The control points carry the datum" in datum(of_control)


NO_MORE = "There are no more control coordinates than the datum needs"


def test_control_that_nothing_checks_has_a_redundancy_of_zero(controlled):
    """Seven coordinates carry the datum, and their residuals are zero whatever."""
    sigma = np.full((3, 3), np.inf)
    sigma[0] = sigma[1] = sigma[2, 2] = 0.05
    given, two = controlled.control[1][[0, 1, 3]], controlled.control[1][:2]
    control = CONTROL[[0, 1, 3]], given, sigma
    least = replace(controlled, fixed=(), scale_bars=(), control=control)
    found = adjusted(least)
    _, shown = table(found, "Control points")
    assert set(shown[:, 4:7].ravel()) == {"0.00", "-"}
    assert set(shown[:, 7:].ravel()) == {"-"}
    assert "Control that does not fit" not in findings(found)
    assert NO_MORE in datum(found)
    bars, six = controlled.scale_bars, [[0.1, 0.1, np.inf], [np.inf, np.inf, 0.1]]
    for changes, said in (
        ({"control": None, "fixed": [0, 5, 11]}, False),
        ({"fixed": [FIXED], "control": (CONTROL[:2], two, sigma[1:])}, True),
        ({"scale_bars": bars}, False),  # they check the scale
        (
            {
                "scale_bars": bars,
                "fixed": [FIXED],
                "control": (CONTROL[:2], two, six),
            },
            True,
        ),
    ):
        other = replace(found, network=replace(least, **changes))
        assert Case(other).least_control == said


def test_a_wrong_control_point_comes_before_the_rays(controlled):
    """30 sigma in Y of P8: the warning, sigma0, the suspects and snooping say so."""
    found = bundle.snoop(with_control(controlled, 4, 1, 1.5), SOME)
    assert found.removed == ()
    said, w = findings(found.result), found.result.control_standardized
    assert np.unravel_index(np.argmax(np.abs(w)), w.shape) == (4, 1)
    control = said["Control that does not fit"]
    assert f"Y of control point P8 (tau = {w[4, 1]:.1f})" in control
    assert "Look at control first: a wrong control point or scale bar spoils" in control
    assert said[STATED].endswith("or a control point or a scale bar is wrong.")
    text = joined(report.text(found, short=True))
    words = "rejected no observation: control point P8 has the largest residual: cor"
    assert words in text and found.stopped in text
    rays = one(found.result.standardized, 0.9 * np.abs(w).max(), 3)
    said = findings(replace(found.result, standardized=rays))["Suspected blunders"]
    assert said.endswith("once it is right, good rays among these fit.")


@pytest.mark.parametrize("of_ray, first", [(4.9, True), (5.1, False)])
def test_what_has_the_larger_residual_is_looked_at_first(of_control, of_ray, first):
    w = one(np.zeros_like(of_control.control_standardized), 5.0, (0, 2))
    rays = one(np.zeros_like(of_control.standardized), -of_ray, (7, 1))
    said = findings(replace(of_control, standardized=rays, control_standardized=w))
    assert ("Look at control first" in said["Control that does not fit"]) == first
    assert ("But a ray has a larger" in said["Control that does not fit"]) != first
    assert ("Control comes first" in said["Suspected blunders"]) == first


def calm(result, **more):
    """No standardised residual at all."""
    names = ("standardized", *KINDS)
    none = {name: np.zeros_like(getattr(result, name)) for name in names}
    return replace(result, **none | more)


@pytest.mark.parametrize("size, warned", [(0.99, False), (1.01, True)])
@pytest.mark.parametrize("kind", KINDS)
def test_the_limit_of_control_is_that_of_the_rays(of_control, kind, size, warned):
    w = np.zeros_like(getattr(of_control, kind))
    w.flat[1] = -size * bundle.critical_value(of_control)
    said = findings(calm(of_control, **{kind: w}))
    assert ("Control that does not fit" in said) == warned


@pytest.mark.parametrize("kind", KINDS)
def test_a_gross_error_of_control_makes_sigma0_as_large_as_one_of_a_ray(
    of_control, kind
):
    """Nothing is said of the parameters before it is corrected."""
    large = calm(of_control, sigma0=2.5)
    assert not Case(large).gross
    w = getattr(large, kind).copy()
    w.flat[0] = 6.0
    assert Case(replace(large, **{kind: w})).gross


def test_observations_without_any_error_can_be_reported(of_control, monkeypatch):
    """Computed data: sigma0 and all standard deviations are zero."""
    names = ["residuals", "standardized", "covariance", "covariance_points"]
    names += [f"{k}_{n}" for k in ("control", "scale_bar") for n in names[:2]]
    nothing = {name: np.zeros_like(getattr(of_control, name)) for name in names}
    exact = replace(of_control, sigma0=0.0, **nothing)
    monkeypatch.setattr(_figures, "of_network", lambda case: lambda name: [])
    with np.errstate(invalid="ignore"):  # correlations of what has no sd
        text, page = report.text(exact), report.html(exact)
    assert "sigma0 is 0, as only computed observations fit without" in joined(text)
    shown = [text, *sum(sum(Page(page).tables.values(), []), [])]
    assert not any("nan" in words or "inf " in words for words in shown)


# --- Figures ---


def drawn(figures):
    """Return the figure and what it shows."""
    with plt.rc_context(plot.STYLE):
        ((figure, shown),) = figures
    return figure, shown


@pytest.fixture
def close():
    yield
    plt.close("all")


def test_many_rays_are_drawn_as_means_that_show_what_the_camera_lacks(
    result, monkeypatch, close
):
    """A bias of 1 µm in x over half of the image stands out, noise does not."""
    monkeypatch.setattr(_figures, "DENSE", 10)
    noise = np.random.default_rng(6).normal(0, 3e-4, result.residuals.shape)
    xy = result.network.xy
    _, shown = drawn(_figures.residuals(Case(replace(result, residuals=noise))))
    assert not shown["single"] and shown["beyond"] <= 1
    noise[xy[:, 0] > np.median(xy[:, 0]), 0] += 1e-3
    _, shown = drawn(_figures.residuals(Case(replace(result, residuals=noise))))
    assert shown["beyond"] >= 5 and 0.8 < shown["largest"] < 1.4


# --- Rounding ---


def test_helpers_of_rounding():
    assert _rounding.fixed(np.array([-0.001, np.nan]), 2) == ["0.00", "-"]
    assert _rounding.scientific(1.234567e-5, 3.2e-8) == ("1.2346e-05", "3.2e-08")
    assert _rounding.scientific(34.56789, 0.0300) == ("34.568", "0.030")
    assert _rounding.scientific(0.0, 2e-9) == ("0.0e+00", "2.0e-09")
