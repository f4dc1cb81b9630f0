"""The report of a bundle adjustment: its numbers, its words, its page."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import matplotlib.pyplot as plt
import numpy as np
import pytest

from pgm_lab import _rounding, bundle, report
from pgm_lab.camera import PARAMETERS
from pgm_lab.report import _figures, _findings, _misfit, _tables, _words
from pgm_lab.report._text import sections
from tests.networks import real


@pytest.fixture(scope="module")
def network():
    """The network of 2013 with ids that cannot be taken for indices."""
    return replace(
        real(),
        photo_names=[100 + i for i in range(9)],
        point_names=[5000 - 7 * j for j in range(50)],
    )


@pytest.fixture(scope="module")
def result(network):
    return bundle.adjust(network)


@pytest.fixture(scope="module")
def everything(network):
    """Two cameras, control, check points, a scale bar, a fixed point, odd names."""
    a, b = network.points[[0, 40]]
    return bundle.adjust(
        replace(
            network,
            cameras=2 * network.cameras,
            camera=[0] * 5 + [1] * 4,
            control=([0, 9, 30], network.points[[0, 9, 30]] + 0.02, 0.05),
            check=([3, 4], network.points[[3, 4]]),
            scale_bars=[(0, 40, np.linalg.norm(a - b) + 0.01, 0.02)],
            fixed=[20],
            photo_names=[f"<b>{i}" for i in range(9)],
            point_names=[f'"{j}"&$x$' for j in range(50)],
        )
    )


@pytest.fixture(scope="module")
def without_redundancy(network):
    """Five points in two photos, and no more."""
    rays = (network.photo < 2) & (network.point < 5)
    few = bundle.Network(
        network.cameras,
        network.exteriors[:2],
        network.points[:5],
        network.photo[rays],
        network.point[rays],
        network.xy[rays],
    )
    return bundle.adjust(few, ())


def table(result, caption):
    """Return the header and rows of the table whose caption begins so."""
    every = [t for part in sections(result, "", False) for t in part.tables]
    (found,) = [t for t in every if t.caption.startswith(caption)]
    return found.header, np.array(found.rows)


def test_each_number_is_the_result_rounded_and_no_digit_more(result):
    """Half a unit of the last digit is what rounding may change."""
    radians = np.hstack([result.exteriors, result.sd_exteriors])
    degrees = np.degrees(radians)
    order = [0, 3, 1, 4, 2, 5]  # value, sd, value, sd, ...
    points = np.hstack([result.points, result.sd_points])
    um = 1e3 * result.residuals
    by_point = [np.sqrt(np.mean(um[result.network.point == j] ** 2)) for j in range(50)]
    centres = [0, 6, 1, 7, 2, 8]
    angles = [3, 9, 4, 10, 5, 11]
    for caption, columns, expected in (
        ("Object points", slice(1, 7), points[:, order]),
        ("Object points", 8, by_point),
        ("Projection centres", slice(1, 7), radians[:, centres]),
        ("Angles of the photos, in radians", slice(1, 7), radians[:, angles]),
        ("Angles of the photos, in degrees", slice(1, 7), degrees[:, angles]),
    ):
        shown = table(result, caption)[1][:, columns]
        decimals = np.vectorize(lambda cell: len(cell.partition(".")[2]))(shown)
        assert np.all(
            np.abs(shown.astype(float) - expected) <= 0.501 * 10.0**-decimals
        ), caption


def test_precision_decides_the_digits(result):
    """A usual standard deviation has two digits, the value as many decimals."""
    _, rows = table(result, "Object points")
    for value, sd in ((1, 2), (3, 4), (5, 6)):
        assert (
            10
            <= np.median([int(re.sub(r"\D", "", cell)) for cell in rows[:, sd]])
            < 200
        )
        assert len({len(cell.partition(".")[2]) for cell in rows[:, value]}) == 1


def test_the_table_of_the_camera_holds_value_sd_and_test(result):
    header, rows = table(result, "Interior orientation")
    assert list(rows[:, 0]) == list(PARAMETERS)
    np.testing.assert_allclose(rows[:, 1].astype(float), result.interior, rtol=0.05)
    np.testing.assert_allclose(rows[:, 3].astype(float), result.sd_interior, rtol=0.05)
    tests = {one.name: one for one in bundle.significance(result)}
    for row in rows[1:]:
        one = tests[row[0]]
        assert float(row[4]) == pytest.approx(one.value / one.sd, abs=0.051)
        assert row[6] == ("yes" if one.significant else "no")
        assert float(row[7]) == pytest.approx(1e3 * one.effect, rel=0.05)


def test_what_was_not_estimated_is_held(network):
    _, rows = table(bundle.adjust(network, ("c",)), "Interior orientation")
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
    network, (_, rows) = result.network, table(result, "Fit of the photos")
    for i, row in enumerate(rows):
        own = network.photo == i
        v, w = 1e3 * result.residuals[own], np.abs(result.standardized[own])
        worst = np.argmax(w.max(axis=1))
        assert row[0] == str(100 + i) and int(row[1]) == np.sum(own)
        rms = np.sqrt(np.mean(v**2, axis=0))
        np.testing.assert_allclose(row[2:4].astype(float), rms, atol=0.0051)
        assert float(row[4]) == pytest.approx(
            result.redundancy_numbers[own].mean(), abs=0.0051
        )
        assert float(row[5]) == pytest.approx(w.max(), abs=0.051)
        assert row[6] == str(network.point_names[network.point[own][worst]])


def test_suspects_come_with_the_ids_of_the_input_the_largest_first(result):
    """Point 29 in photo 6 of the source is the largest: 28 and 5 counted from 0."""
    _, rows = table(result, "Suspected blunders")
    assert list(rows[0, :2]) == [str(5000 - 7 * 28), "105"]
    largest = np.abs(rows[:, 4:6].astype(float)).max(axis=1)
    assert np.all(np.diff(largest) <= 0)
    count = np.sum(np.abs(result.standardized).max(1) > bundle.critical_value(result))
    assert len(rows) == count
    assert f"point {5000 - 7 * 28} in photo 105" in report.text(result, short=True)


@pytest.mark.parametrize(
    "sigma0, words",
    [
        (1.0, "as good as stated"),
        (1.06, "as good as stated"),
        (0.8, "about 20 % better than stated"),
        (1.5, "about 50 % worse than stated"),
        (0.349, "about three times better than stated"),
        (0.4, "about 2.5 times better than stated"),
        (2.1, "about two times worse than stated"),
        (12.1, "about twelve times worse than stated"),
        (250.0, "about 250 times worse than stated"),
        (1e-4, "about 10000 times better than stated"),
    ],
)
def test_sigma0_in_words(result, sigma0, words):
    assert words in _words.summary(replace(result, sigma0=sigma0))


def test_sigma0_is_compared_with_what_was_known_before(result):
    known = replace(result, sigma0=0.35, sigma0_prior=0.35)
    assert "as good as stated, 0.35 µm in place of 0.35 µm" in _words.summary(known)
    assert "Stated standard deviations" not in titles(known)


def test_the_summary_counts_what_the_redundancy_is_made_of(result, everything):
    for one, inner in ((result, "7 inner constraints"), (everything, "9 control")):
        text = _words.summary(one)
        numbers = re.search(r"rays?\. (.*) for (\d+) unknowns, redundancy (\d+)", text)
        against = numbers[1].replace("one ", "1 ")
        observed = sum(int(number) for number in re.findall(r"\d+", against))
        assert observed - int(numbers[2]) == int(numbers[3]) == one.redundancy
        assert inner in text


def titles(result):
    return [finding.title for finding in _findings.findings(result)]


def quiet(result):
    """Return the result without anything to warn of."""
    n = len(result.names)
    return replace(
        result,
        sigma0=1.0,
        standardized=0.1 * np.ones_like(result.standardized),
        covariance=np.diag(np.full(n, 1e-30)),
    )


def test_nothing_is_warned_of_where_nothing_is_wrong(result):
    good = quiet(result)
    assert titles(good) == []
    assert "Nothing to warn of." in report.text(good)


def _weak_first_photo(result):
    covariance = result.covariance.copy()
    covariance[range(10, 13), range(10, 13)] = 1.0
    return replace(result, covariance=covariance)


def _correlated(result):
    covariance = result.covariance.copy()
    covariance[0, 1] = covariance[1, 0] = 0.95e-30
    return replace(result, covariance=covariance)


def _one(values, value):
    values = values.copy()
    values[7] = value
    return values


WARNED = {
    "No solution": lambda r: replace(r, status="diverged"),
    "Stated standard deviations": lambda r: replace(r, sigma0=1.06),
    "No redundancy": lambda r: replace(r, redundancy=0, sigma0=np.nan),
    "Suspected blunders": lambda r: replace(r, standardized=_one(r.standardized, 3.4)),
    "Behind the camera": lambda r: replace(r, points=_one(r.points, (0, -9000, 0))),
    "Correlations above 0.9": _correlated,
    "Insignificant parameters": lambda r: replace(
        r, cameras=(replace(r.cameras[0], P1=1e-16),)
    ),
    "Hardly controlled observations": lambda r: replace(
        r, redundancy_numbers=_one(r.redundancy_numbers, 0.09)
    ),
    "Weak photos": _weak_first_photo,
    "Points with two rays": lambda r: replace(
        r,
        network=r.network.without(
            np.flatnonzero((r.network.point == 3) & (r.network.photo > 1))
        ),
        residuals=r.residuals[:-7],
        standardized=r.standardized[:-7],
        redundancy_numbers=r.redundancy_numbers[:-7],
    ),
}


@pytest.mark.parametrize("title", WARNED)
def test_each_warning_comes_with_its_cause_and_alone(result, title):
    assert titles(WARNED[title](quiet(result))) == [title]


def test_a_photo_with_few_rays_is_weak_whatever_its_precision(result):
    network, good = result.network, quiet(result)
    for left, weak in ((5, [8]), (6, [])):
        few = np.flatnonzero((network.photo == 8) & (network.point >= left))
        sparse = replace(good, network=network.without(few))
        assert list(_findings.weak_photos(sparse)) == weak


def test_a_weak_photo_is_named_with_its_rays(network):
    few = np.flatnonzero((network.photo == 8) & (network.point > 4))
    text = report.text(bundle.adjust(network.without(few), ("c",)), short=True)
    assert "Weak photos: 108 (5 rays)" in text


def test_without_redundancy_no_number_is_invented(without_redundancy):
    assert without_redundancy.redundancy == 0
    text = report.text(without_redundancy)
    assert "nan" not in text and "inf" not in text.replace("information", "")
    _, rows = table(without_redundancy, "Object points")
    assert set(rows[:, [2, 4, 6, 9]].ravel()) == {"-"}


def test_the_datum_is_said_with_what_it_means(network, everything):
    inner = report.text(bundle.adjust(network, ("c",)), short=True)
    assert "inner constraints on all points" in inner
    photos = report.text(bundle.adjust(network, ("c",), "photos"), short=True)
    assert "inner constraints on the projection centres" in photos
    some = bundle.adjust(replace(network, datum_points=[1, 2, 3, 4]), ("c",))
    assert "inner constraints on 4 chosen points" in report.text(some).replace(
        "\n", " "
    )
    assert "The control points carry the datum" in report.text(everything)


def test_control_check_points_and_bars_have_their_tables(everything):
    for caption, differences in (
        ("Control points", everything.control_residuals),
        ("Check points", everything.check_differences),
    ):
        shown = table(everything, caption)[1][:, 1:4].astype(float)
        np.testing.assert_allclose(shown, differences, rtol=0.2, atol=1e-3)
    _, rows = table(everything, "Scale bars")
    assert rows[0, 0] == '"0"&$x$ to "40"&$x$'
    assert table(everything, "Object points")[1][20, 2] == "held"


def test_snooping_is_told_with_what_it_took_out(network, monkeypatch):
    monkeypatch.setattr(_figures, "pictures", lambda *_: [])
    found = bundle.snoop(network)
    text = report.text(found)
    assert f"took out {len(found.removed)} rays, one at a time" in text
    _, rows = table(found, "Rays taken out")
    assert [tuple(row[1:3]) for row in rows] == [
        (str(one.point), str(one.photo)) for one in found.removed
    ]
    assert "Rays taken out" in report.html(found)
    clean = bundle.snoop(found.result.network, most=0)
    assert "rejected no observation" in report.text(clean)


def test_a_short_report_has_no_long_tables(result):
    short, whole = report.text(result, short=True), report.text(result)
    assert "Object points" in whole and "Object points" not in short
    assert len(short.splitlines()) < 100 < len(whole.splitlines())


def test_the_lines_of_a_paragraph_are_short_and_tables_are_straight(everything):
    for part in sections(everything, "about", False):
        for one in part.tables:
            assert {len(row) for row in one.rows} == {len(one.header)}
    lines = report.text(everything).splitlines()
    assert all(len(line) <= 88 for line in lines if "  " not in line.strip())
    start = next(i for i, line in enumerate(lines) if line.startswith("Object points"))
    body = lines[start + 2 : start + 53]
    assert len({line.rindex("  ") for line in body}) <= 3


class Page(HTMLParser):
    """What a reader with a screen reader needs of a page, collected."""

    VOID = {"meta", "img", "br", "link"}

    def __init__(self, page):
        super().__init__()
        self.elements, self.open, self.text = [], [], []
        self.feed(page)
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)

    def all(self, tag):
        return [attributes for name, attributes in self.elements if name == tag]


ABOUT = "<script>alert(1)</script>"


@pytest.fixture(scope="module")
def source(everything):
    return report.html(everything, about=ABOUT)


def test_the_page_is_one_file_that_everyone_can_read(everything, source):
    page = Page(source)
    assert page.all("html") == [{"lang": "en"}]
    assert len(page.all("h1")) == len(page.all("title")) == 1
    assert not page.all("script") and not page.all("link")
    images = page.all("img")
    assert len(images) == 5  # residuals, two lenses, stations, precision
    for image in images:
        assert image["src"].startswith("data:image/png;base64,")
        assert len(image["alt"]) > 40
    assert all(head.get("scope") in ("col", "row") for head in page.all("th"))
    rows = sum(
        len(t.rows) + 1 for s in sections(everything, "", False) for t in s.tables
    )
    assert len(page.all("tr")) == rows
    assert len(page.all("caption")) == len(page.all("table"))
    targets = {section.get("id") for section in page.all("section")}
    assert {link["href"].removeprefix("#") for link in page.all("a")} <= targets
    assert "http" not in source and "url(" not in source


def test_ids_are_shown_as_they_are_and_never_as_markup(source):
    page = Page(source)
    assert not page.all("b")
    shown = "".join(page.text)
    assert '"20"&$x$' in shown and "<b>8" in shown
    assert '"8"&$x$ in photo <b>6' in shown


def test_the_same_result_gives_the_same_page(everything, source):
    assert report.html(everything, about=ABOUT) == source


def test_the_page_of_a_network_without_redundancy(without_redundancy):
    page = Page(report.html(without_redundancy))
    assert len(page.all("img")) == 2  # there is no precision to draw


def test_helpers_of_rounding():
    assert _rounding.fixed(np.array([-0.001, np.nan]), 2) == ["0.00", "-"]
    assert _rounding.scientific(1.234567e-5, 3.2e-8) == ("1.2346e-05", "3.2e-08")
    assert _rounding.scientific(34.56789, 0.0300) == ("34.568", "0.030")
    assert _rounding.scientific(0.0, 2e-9) == ("0.0e+00", "2.0e-09")


def test_many_rays_are_drawn_as_means_that_show_what_the_camera_lacks(
    result, monkeypatch
):
    """A bias of 1 µm in x over half of the image stands out, noise does not."""
    monkeypatch.setattr(_figures, "DENSE", 10)
    noise = np.random.default_rng(6).normal(0, 3e-4, result.residuals.shape)
    xy = result.network.xy
    ((figure, words),) = _figures.residuals(replace(result, residuals=noise))
    plt.close(figure)
    assert int(re.search(r"(\d+) are longer", words)[1]) <= 1
    noise[xy[:, 0] > np.median(xy[:, 0]), 0] += 1e-3
    ((figure, words),) = _figures.residuals(replace(result, residuals=noise))
    assert int(re.search(r"(\d+) are longer", words)[1]) >= 5
    assert 0.8 < float(re.search(r"largest is ([\d.]+) µm", words)[1]) < 1.4
    plt.close(figure)


def test_as_many_suspects_as_chance_gives_are_called_so(result):
    """900 coordinates: one beyond the limit is chance, five are not."""
    good = quiet(result)
    for number, words in ((1, "no more than chance"), (5, "Look at the largest first")):
        w = good.standardized.copy()
        w[:number, 0] = 3.4
        (finding,) = _findings.findings(replace(good, standardized=w))
        assert words in finding.words


def test_only_the_largest_of_many_suspects_are_listed(result):
    w = np.full_like(result.standardized, 5.0)
    w[11] = 9.0
    header, rows = table(replace(result, standardized=w), "Suspected blunders")
    assert len(rows) == _tables.MOST
    assert rows[0, 0] == str(result.network.point_names[result.network.point[11]])


def blundered(network, size, ray=20):
    xy = network.xy.copy()
    xy[ray, 0] += size
    return replace(network, xy=xy)


def words(result, title):
    (found,) = [one.words for one in _findings.findings(result) if one.title == title]
    return found


@pytest.mark.parametrize(
    "value, digits, written",
    [
        (364.0, 2, "360"),
        (2870.4, 3, "2870"),
        (0.349, 2, "0.35"),
        (1.0, 3, "1"),
        (9.996, 3, "10"),
        (1e-13, 2, "0.0000000000001"),
        (np.nan, 2, "nan"),
    ],
)
def test_a_plain_number_has_no_exponent(value, digits, written):
    assert _rounding.plain(value, digits) == written


@pytest.mark.parametrize("prior", [None, 1.0])
def test_standard_deviations_in_micrometres_are_asked_about(network, prior):
    """1 µm given as 1 mm: sigma0 is 1000 times too small, and no number hides it."""
    wrong = replace(network, sigma=1000 * network.sigma)
    result = bundle.adjust(wrong, sigma0_prior=prior)
    said = words(result, "Stated standard deviations")
    assert "are the standard deviations in µm? Those of" in said
    assert "sigma0 = 0.000349 is not 1" in said
    text = report.text(result, short=True)
    assert "about 2870 times better" in re.sub(r"\s+", " ", text)
    assert not re.search(r"\de[-+]\d+ (µm|times)", re.sub(r"\s+", " ", text))
    few = replace(result, sigma0=0.011, sigma0_prior=prior)
    assert "in µm?" not in words(few, "Stated standard deviations")


@pytest.mark.parametrize("prior", [None, 1.0])
@pytest.mark.parametrize("size", [0.1, 0.5, 2.0])
def test_a_gross_blunder_comes_before_the_parameters(network, size, prior):
    """It makes sigma0 and so all standard deviations large."""
    result = bundle.adjust(blundered(network, size), sigma0_prior=prior)
    said = words(result, "Insignificant parameters")
    assert said.startswith("First the blunders: as long as they make sigma0")
    assert "Leave out" not in said and "e+" not in said
    good = bundle.adjust(network, sigma0_prior=prior)
    assert "Leave out one at a time" in words(good, "Insignificant parameters")


@pytest.mark.parametrize("prior", [None, 1.0])
def test_a_large_sigma0_alone_is_no_blunder(network, prior):
    """Stated three times too well, all of them: the parameters can be judged."""
    result = bundle.adjust(
        replace(network, sigma=network.sigma / 30), sigma0_prior=prior
    )
    even = np.clip(result.standardized, *(np.array([-2.5, 2.5]) * _unit(result)))
    assert "Leave out" in words(
        replace(result, standardized=even), "Insignificant parameters"
    )


def test_what_is_small_or_large_is_so_beside_what_was_stated(network):
    """A sigma0 of 0.002 is twice what was known before, and no slip of the unit."""
    few = bundle.adjust(blundered(network, 0.5), sigma0_prior=10.0)
    assert "Leave out" in words(few, "Insignificant parameters")  # 15 is 1.5 times 10
    many = bundle.adjust(blundered(network, 0.05), sigma0_prior=0.35)
    assert "First the bl" in words(many, "Insignificant parameters")  # 1.57 is not 0.35
    known = replace(few, sigma0=0.002, sigma0_prior=0.001)
    assert "in µm?" not in words(known, "Stated standard deviations")
    slip = replace(few, sigma0=0.09, sigma0_prior=10.0)
    assert "in µm?" in words(slip, "Stated standard deviations")


def test_the_summary_of_a_bad_fit_has_no_exponent(result):
    said = _words.summary(replace(result, sigma0=2870.4))
    assert "sigma0 is 2870, so" in said and "2900 µm in place of 1 µm" in said


def _unit(result):
    """How large a usual standardised residual is."""
    return result.sigma0 / result.sigma0_prior if result.sigma0_prior else 1.0


@pytest.mark.parametrize("seed", range(4))
def test_two_interchanged_points_are_recognised(network, seed):
    """Neighbours of one photo: each lies where the other should be."""
    rng = np.random.default_rng(seed)
    photo = rng.integers(9)
    own = np.flatnonzero(network.photo == photo)
    a = rng.choice(own)
    distance = np.linalg.norm(network.xy[own] - network.xy[a], axis=1)
    b = own[np.argsort(distance)[1]]
    xy = network.xy.copy()
    xy[[a, b]] = xy[[b, a]]
    result = bundle.adjust(replace(network, xy=xy))
    assert _misfit.interchanged(result) in ([(a, b)], [(b, a)])
    names = {network.point_names[network.point[k]] for k in (a, b)}
    said = re.search(
        r"Interchanged, it seems: points (\d+) and (\d+) in photo (\d+)\.",
        words(result, "Suspected blunders"),
    )
    assert {int(said[1]), int(said[2])} == names and int(said[3]) == 100 + photo


def test_only_the_pair_with_the_largest_residual_is_named(network, result):
    """An interchange makes the same two points suspect in other photos too."""
    v, w = np.zeros_like(result.residuals), np.zeros_like(result.standardized)
    for a, b, size in ((20, 30, 5.0), (70, 80, 9.0)):
        d = network.xy[a] - network.xy[b]
        v[[a, b]] = -result.redundancy_numbers[[a, b]] * np.array([d, -d])
        w[[a, b]] = size
    both = replace(result, residuals=v, standardized=w)
    assert len(_misfit.interchanged(both)) == 2
    said = words(both, "Suspected blunders").partition("Interchanged, it seems: ")[2]
    a, b = network.point_names[20], network.point_names[30]
    assert said == f"points {a} and {b} in photo 101."


def test_other_blunders_are_no_interchange(network, result):
    """In one photo, in two photos, in the same direction, or of another size."""
    a, b, elsewhere = 20, 30, 70
    assert network.photo[a] == network.photo[b] != network.photo[elsewhere]
    difference = network.xy[a] - network.xy[b]
    exchange = (difference, -difference)
    far = network.xy[a] - network.xy[elsewhere]
    for at, errors in (
        ((a, b), exchange),
        ((a, b), (difference, difference)),
        ((a, b), (3 * difference, -3 * difference)),
        ((a, b), (difference, 0.1 * difference)),
        ((a, b), (-difference, difference)),
        ((a, elsewhere), (far, -far)),
    ):
        v, w = np.zeros_like(result.residuals), np.zeros_like(result.standardized)
        w[list(at)] = 9.0
        v[list(at)] = -result.redundancy_numbers[list(at)] * np.array(errors)
        found = _misfit.interchanged(replace(result, residuals=v, standardized=w))
        assert found == ([(a, b)] if errors is exchange else [])
    assert "Interchanged" not in report.text(result)


def test_the_columns_of_the_files_are_found_in_the_conventions(result):
    assert "X0, Y0, Z0 are the projection centre, XL, YL, ZL in the files" in " ".join(
        _words.conventions(result)
    )


def test_the_report_says_which_test_its_residuals_are_for_and_whence_its_limit(
    everything,
):
    """Pope's tau without a stated sigma0, else Baarda's w: in words and all tables."""
    text = report.text(everything)
    tau = rf"{bundle.critical_value(everything):.2f} (Pope's tau, with the estimated"
    assert tau + f" sigma0, redundancy {everything.redundancy};" in " ".join(
        text.split()
    )
    assert "tau (Pope's, with the sigma0 estimated" in " ".join(text.split())
    assert not re.search(r"\|w\||\bw\b( [xXyYZ])?", text)
    for head in ("largest |tau|", "tau x  tau y", "tau X  tau Y  tau Z"):
        assert head in re.sub(" {2,}", "  ", text)
    stated = bundle.adjust(everything.network, sigma0_prior=0.3)
    text = report.text(stated)
    assert "3.29 (Baarda's w, with the stated sigma0; one" in " ".join(text.split())
    assert "w (Baarda's, with the sigma0 stated before" in " ".join(text.split())
    assert "tau" not in text
    for head in ("largest |w|", "w x  w y", "w X  w Y  w Z"):
        assert head in re.sub(" {2,}", "  ", text)


def test_the_limit_of_the_network_of_2013_is_that_of_tau_for_693(network):
    found = bundle.snoop(network, most=1)
    text = report.text(found, short=True)
    said = (
        "above 3.28 (Pope's tau, with the estimated sigma0, redundancy 691; one false"
    )
    assert said in " ".join(text.split())
    assert re.search(r"step +point +photo +tau x +tau y", text)
    tested = "Residuals were tested by Pope's tau, its limit is 3.28."
    assert tested in " ".join(text.split())
