"""The pages: formulas as people write them, markup, odd names, a phone."""

import re
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import pytest

from pgm_lab import bundle, plot, registration, report
from pgm_lab.report import _figures, network
from pgm_lab.report._page import typesetter
from tests.matching import photos
from tests.networks import real
from tests.registration import images
from tests.report.pages import Page, plain

STATUS = ["accepted"] * 30 + ["ambiguous"] * 4 + ["below threshold"] * 6
MARKUP = "<script>alert(1)</script><img src=x onerror=alert(1)>r^2.png"


@pytest.fixture(scope="module")
def odd():
    """Two cameras, control, check points, a scale bar, a fixed point, odd names."""
    net = real()
    a, b = net.points[[0, 40]]
    return bundle.adjust(
        replace(
            net,
            cameras=2 * net.cameras,
            camera=[0] * 5 + [1] * 4,
            control=([0, 9, 30], net.points[[0, 9, 30]] + 0.02, 0.05),
            check=([3, 4], net.points[[3, 4]]),
            scale_bars=[(0, 40, np.linalg.norm(a - b) + 0.01, 0.02)],
            fixed=[20],
            photo_names=[f"<b>{i}" for i in range(9)],
            point_names=[f'"{j}"&$\\frac{{{j}}}$' for j in range(50)],
        )
    )


def of_network(odd):
    return report.html(odd, about=MARKUP)


def of_matching(_):
    found = photos.result(status=STATUS)
    return report.matching.html(found, *photos.pair(), about=MARKUP)


def of_registration(_):
    pair = images.pair()
    points = registration.pick(pair[0], 40, sensed=pair[1])
    found = registration.register(*pair, points, refine="lsm")
    words = {"model": registration.fit(found), "settings": {"refine": "lsm"}}
    return report.registration.html(found, *pair, **words, about=MARKUP)


# Residuals, two lenses, stations, precision; photos, histograms, parallaxes; overlay,
# scatter, shifts, what the model leaves of them, similarity
FIGURES = {of_network: 5, of_matching: 3, of_registration: 5}


@pytest.fixture(scope="module", params=FIGURES)
def page(request, odd):
    """The source of each page, and how many figures it has."""
    return request.param(odd), FIGURES[request.param]


def test_the_page_is_one_file_that_everyone_can_read(page):
    source, figures = page
    one = Page(source)
    assert one.all("html") == [{"lang": "en"}]
    assert len(one.all("h1")) == len(one.all("title")) == 1
    assert not one.all("script") and not one.all("link")
    assert len(one.all("img")) == figures
    for image in one.all("img"):
        assert image["src"].startswith("data:image/png;base64,")
        assert len(image["src"]) > 10_000 and len(image["alt"]) > 60
    assert all(head.get("scope") in ("col", "row") for head in one.all("th"))
    tables = Page(plain(source)).tables
    assert len(one.all("caption")) == len(one.all("table")) == len(tables)
    for table in tables.values():
        assert len({len(row) for row in table}) == 1 < len(table)
    targets = {section.get("id") for section in one.all("section")}
    assert {link["href"].removeprefix("#") for link in one.all("a")} <= targets
    assert "http" not in source and "url(" not in source and "@import" not in source


def test_names_are_shown_as_they_are_and_never_as_markup(page):
    source, _ = page
    assert "<script" not in source and "<img src=x" not in source
    assert "<b>" not in source and MARKUP in "".join(Page(source).text)


@pytest.mark.slow
def test_names_with_mathematics_in_them_are_drawn_as_they_are(odd):
    """matplotlib takes what stands between dollars for a formula, and stumbles."""
    text = "".join(Page(report.html(odd)).text)
    assert '"20"&$\\frac{20}$' in text and '"8"&$\\frac{8}$ in photo <b>6' in text
    figure = plot.bundle.residual_vectors(odd)
    figure.canvas.draw()
    plt.close(figure)


@pytest.mark.slow
def test_the_same_result_gives_the_same_page(page, odd, request):
    source, _ = page
    assert request.node.callspec.params["page"](odd) == source


def test_no_plain_formula_is_left_on_the_page(monkeypatch):
    monkeypatch.setattr(_figures, "png", lambda figure: plt.close(figure) or "png")
    found = bundle.snoop(real(), most=2)
    page = report.html(found)
    body = re.sub('<img[^>]*>|aria-label="[^"]*"', "", page.partition("<main>")[2])
    words = re.sub("<[^>]*>", "", body)
    assert not re.search(r"\w\^|sigma0(?!_)|[0-9]e[-+][0-9]|(?<![^ (>])-[0-9]", words)
    text = report.text(found)
    assert "sigma0" in text and "^-2" in text


def test_the_lines_of_a_paragraph_are_short_and_tables_are_straight(odd):
    for part in network.Case(odd).sections("about", False):
        for one in part.tables:
            assert {len(row) for row in one.rows} == {len(one.header)}
    lines = report.text(odd).splitlines()
    assert all(len(line) <= 88 for line in lines if "  " not in line.strip())
    start = next(i for i, line in enumerate(lines) if line.startswith("Object points"))
    body = lines[start + 2 : start + 53]
    assert len({line.rindex("  ") for line in body}) <= 3


@pytest.mark.parametrize(
    "text, html",
    [
        ("K1 rho^3", "K<sub>1</sub> ρ<sup>3</sup>"),
        ("dx = a0, dy = b0.", "dx = a<sub>0</sub>, dy = b<sub>0</sub>."),
        ("b0.txt", "b0.txt"),
        ("mm^-2", "mm<sup>−2</sup>"),
        ("sigma0^2 = v'Pv", "σ<sub>0</sub><sup>2</sup> = v<sup>T</sup>Pv"),
        ("a sigma0_prior", "a sigma0_prior"),
        ("1.2346e-05", "1.2346 × 10<sup>−5</sup>"),
        ("-3e+08", "−3 × 10<sup>8</sup>"),
        ("x - x0 = -c U / W", "x − x<sub>0</sub> = −c U / W"),
        ("M_kappa M_phi", "M<sub>κ</sub> M<sub>φ</sub>"),
        ("sqrt(P1^2)", "√(P<sub>1</sub><sup>2</sup>)"),
        ("largest |tau|", "largest |τ|"),
        ("sd omega", "sd ω"),
        ("(-0.98), t = -1.3", "(−0.98), t = −1.3"),
        ("5-6, a-b, -", "5-6, a-b, -"),
        ("a < b & c", "a &lt; b &amp; c"),
        ("free network", "free network"),
    ],
)
def test_formulas_and_numbers_are_typeset(text, html):
    assert typesetter([])(text) == html
    assert plain(html.replace("&lt;", "<").replace("&amp;", "&")) == text


@pytest.mark.parametrize("name", ["r^2", "sigma0", "-3", "K1", "1e-05", "<b>r^2</b>"])
def test_names_are_never_typeset(name):
    html = typesetter([name, 5])(f"point {name} in photo 5, r^3: -2.5")
    shown = name.replace("<", "&lt;").replace(">", "&gt;")
    assert html == f"point {shown} in photo 5, r<sup>3</sup>: −2.5"
