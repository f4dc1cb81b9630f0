"""The page: formulas as people write them, a picture in space, a phone, odd names."""

import os
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest

from pgm_lab import bundle, plot, report
from pgm_lab.report import _figures, _limits, _space
from pgm_lab.report._text import sections
from pgm_lab.report._typeset import typesetter
from tests.networks import real
from tests.report.test_control import plain


@pytest.fixture(scope="module")
def result():
    return bundle.adjust(real())


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


def test_no_plain_formula_is_left_on_the_page(result, monkeypatch):
    monkeypatch.setattr(_figures, "png", lambda figure: plt.close(figure) or "png")
    page = report.html(bundle.snoop(result.network, most=2))
    body = re.sub('<img[^>]*>|aria-label="[^"]*"', "", page.partition("<main>")[2])
    words = re.sub("<[^>]*>", "", body)
    assert not re.search(r"\w\^|sigma0(?!_)|[0-9]e[-+][0-9]|(?<![^ (>])-[0-9]", words)
    assert "sigma0" in report.text(result) and "^-2" in report.text(result)


def test_names_with_mathematics_in_them_are_drawn_as_they_are(result):
    """matplotlib takes what stands between dollars for a formula, and stumbles."""
    odd = [rf"$\frac{{{i}}}$" for i in range(50)]
    network = replace(result.network, photo_names=odd[:9], point_names=odd)
    page = report.html(replace(result, network=network))
    assert page.count("<img") == 4
    assert "$\\frac{28}$ in photo $\\frac{5}$" in page
    figure = plot.bundle.standardized_histogram(replace(result, network=network))
    figure.canvas.draw()
    plt.close(figure)


def stations(result):
    with plt.rc_context(plot.STYLE):
        ((figure, words),) = _space.stations(result)
    return figure, words


def test_stations_and_points_are_drawn_in_space(result):
    """The last step of the program of 2013: one scale, units on three axes."""
    figure, words = stations(result)
    (ax,) = figure.axes
    labels = [ax.get_xlabel(), ax.get_ylabel(), ax.get_zlabel()]
    assert labels == [f"{axis} (object units)" for axis in "XYZ"]
    for expected in (result.points, result.exteriors[:, :3]):
        drawn = [np.transpose(one._offsets3d) for one in ax.collections[:2]]
        assert any(np.shape(d) == expected.shape and np.allclose(d, expected)
                   for d in drawn)  # fmt: skip
    limits = np.array([ax.get_xlim(), ax.get_ylim(), ax.get_zlim()])
    everything = np.concatenate([result.points, result.exteriors[:, :3]])
    assert np.all(limits[:, 0] <= everything.min(axis=0))
    assert np.all(limits[:, 1] >= everything.max(axis=0))
    scale = ax._box_aspect / np.ptp(limits, axis=1)
    np.testing.assert_allclose(scale, scale[0])
    names = {text.get_text() for text in ax.texts}
    assert {"1, 2", "3, 4, 5", "6", "7", "8, 9"} == names  # close ones together
    assert "9 projection centres as squares" in words and "50 object points" in words
    assert "Y from 0 to 1751" in words
    plt.close(figure)


def test_coordinates_of_a_national_system_are_told_apart(result):
    exteriors = result.exteriors.copy()
    exteriors[:, :3] += 5e6
    figure, words = stations(
        replace(result, points=result.points + 5e6, exteriors=exteriors)
    )
    assert "Y from 5000000 to 5001751" in words
    plt.close(figure)


@pytest.mark.parametrize("most, cameras", [(8, 0), (9, 9)])
def test_many_cameras_are_drawn_as_dots_alone(result, monkeypatch, most, cameras):
    monkeypatch.setattr(_space, "MOST_CAMERAS", most)
    monkeypatch.setattr(_space, "MOST_NAMES", 8)
    monkeypatch.setattr(_space, "MOST_POINTS", 20)
    drawn = []
    camera = plot.space.draw_camera
    monkeypatch.setattr(
        plot.space, "draw_camera", lambda *a, **k: drawn.append(a) or camera(*a, **k)
    )
    figure, words = stations(result)
    assert len(drawn) == cameras and "50 object points" in words
    assert not figure.axes[0].texts
    assert len(figure.axes[0].collections[0]._offsets3d[0]) == 17  # each third
    plt.close(figure)


def test_the_picture_is_in_the_page_and_the_text_has_none(result, monkeypatch):
    titles = {part.title: part.figures for part in sections(result, "", False)}
    assert titles["Photos"] == ("stations",)
    ((png, words),) = _figures.pictures("stations", result)
    assert len(png) > 10_000
    monkeypatch.setattr(_figures, "png", lambda figure: plt.close(figure) or "png")
    assert f'src="data:image/png;base64,png" alt="{words}"' in report.html(result)


def test_each_limit_of_the_report_has_its_reason(result):
    text = " ".join(report.text(result).split())
    for words in (
        "above 3.28 makes a ray suspect: chance takes one of a thousand",
        "Pope's tau with the redundancy 693; the larger that is, the nearer the limit"
        " comes to 3.29",
        "tested at 5 %, the usual level: one right model of 20 is called wrong",
        "above 0.9: there the sd of an unknown is more than 2.3 times",
        "below 0.1 is called hardly controlled, as nine tenths",
        "fewer than six rays: so many points give twice the coordinates",
        "more than three times as uncertain as the median one; this is a choice",
        "more than 2 times the stated one and a residual is more than 1.5 times",
        "less than 0.25 mm or more than 300 mm from the middle, as in no camera, or 3",
        "standard deviations below 10 nm, which nobody measures",
    ):
        assert words in text
    assert "Limits" not in report.text(result, short=True)
    known = replace(result, sigma0_prior=0.35)
    assert "above 3.29" in _limits.limits(known)[0]
    assert (
        "stated before, so its limit is that of the normal" in _limits.limits(known)[0]
    )
    few = replace(result, redundancy=1)
    assert _limits.limits(few)[0] == "Without redundancy no residual can be tested."


BROWSER = next(
    filter(None, map(shutil.which, ("chromium", "google-chrome", "chrome"))), None
)


@pytest.mark.slow
@pytest.mark.skipif(not BROWSER or os.name == "nt", reason="needs a browser")
def test_on_a_phone_nothing_is_wider_than_the_page_but_in_its_own_box(
    result, tmp_path: Path
):
    """In a window of 390 px: figures 700 px wide, tables and they scroll alone."""
    long = "x" * 300
    page = tmp_path / "r.html"
    probe = """<iframe id="phone" style="width:390px;height:900px" src="r.html">
</iframe>
<script>onload = () => {
  const page = document.getElementById("phone").contentDocument;
  const wide = page.documentElement.scrollWidth;
  const images = [...page.images].map(one => Math.round(one.width));
  const boxes = [...page.querySelectorAll("figure, .table")].map(
    box => box.clientWidth <= 390 && getComputedStyle(box).overflowX == "auto");
  const captions = [...page.querySelectorAll("caption span")].map(
    one => one.getBoundingClientRect().width <= 390);
  document.body.innerText = JSON.stringify(
    [wide, Math.min(...images), boxes.every(Boolean), captions.every(Boolean)]);
}</script>"""
    page.write_text(report.html(result, about=f"From {long}.txt."), encoding="utf-8")
    (tmp_path / "probe.html").write_text(probe)
    call = [BROWSER, "--headless", "--no-sandbox", "--disable-gpu", "--dump-dom"]
    call += ["--allow-file-access-from-files", "--virtual-time-budget=5000"]
    call += ["--disable-web-security", f"--user-data-dir={tmp_path / 'user'}"]
    call += [(tmp_path / "probe.html").as_uri()]
    done = subprocess.run(call, capture_output=True, text=True, timeout=120)
    found = re.search(r"\[(\d+),(\d+),(\w+),(\w+)\]", done.stdout)
    assert found, done.stderr
    assert int(found[1]) <= 390 and int(found[2]) >= 700
    assert found[3] == found[4] == "true"
