"""The report of a calibration: its numbers, and what it says is missing."""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import pytest

from pgm_lab import report
from pgm_lab.calibration import calibrate
from pgm_lab.calibration.solve import SQUARE
from pgm_lab.report import _figures
from pgm_lab.report.calibration import Case, text
from tests.calibration import rendered
from tests.report.pages import Page, joined, plain


@pytest.fixture(scope="module")
def found():
    photos = rendered.scene()[2]
    return calibrate(photos, rendered.BOARD, pixel_size=0.01, estimate=SQUARE)


def titles(found, **settings):
    return [one.title for one in Case(found, False, **settings).findings]


def test_the_page_has_its_numbers_tables_and_pictures(found, monkeypatch):
    monkeypatch.setattr(_figures, "png", lambda figure: plt.close(figure) or "png")
    page = report.calibration.html(found, about="Ten photos.")
    words = joined(plain(page))
    c, sd = found.camera.c / 0.01, np.sqrt(found.covariance[0, 0]) / 0.01
    assert f"c = {c:.3f} px, known to {sd:.3f} px" in words
    assert "From 10 photos with" in words and "Ten photos." in words
    tables = Page(plain(page)).tables
    (camera,) = [rows for name, rows in tables.items() if name.startswith("Interior")]
    assert camera[1][0] == "c" and camera[-1][:3] == ["b2", "0", "held"]
    (photos,) = [rows for name, rows in tables.items() if name.startswith("Photos")]
    assert len(photos) == 11 and photos[1][0] == "photo 0"
    alts = [one["alt"] for one in Page(page).all("img")]
    assert len(alts) == 5
    assert "The image with all" in alts[0] and "The board seen from above" in alts[-1]


def test_the_text_is_for_a_terminal_and_a_nominal_pixel_gives_no_millimetres(found):
    long, short = (text(found, nominal=True, short=one) for one in (False, True))
    assert "Photos\n------" in long and "Photos\n------" not in short
    assert "The size of a pixel is not known" in " ".join(short.split())
    assert "mm^-2" not in long and "mm^-2" in text(found)
    assert max(map(len, short.splitlines())) <= 88


def test_a_bent_board_is_named_with_what_flatness_would_have_cost(found):
    words = joined(text(found))
    z = found.shape[:, 2]
    i = np.argmax(np.abs(z))
    name = found.result.network.point_names[i]
    assert f"The board is not flat: point {name} lies {z[i]:.2g} mm off" in words
    off = abs(found.flat.cameras[0].c - found.camera.c) / np.sqrt(
        found.covariance[0, 0]
    )
    assert f"{off:.1f} standard deviations" in words


def test_a_good_network_has_no_warnings_and_each_lack_has_one(found):
    assert titles(found) in ([], ["Rejected corners"])
    level = found.result.exteriors.copy()
    level[:, 3:] = 0
    same = replace(found, result=replace(found.result, exteriors=level))
    assert "All from nearly the same direction" in titles(same)
    assert "No photo turned by 90 degrees" in titles(same)
    photos = [replace(one, pixels=one.pixels / 4) for one in found.photos]
    corner = replace(found, photos=tuple(photos))
    assert "Parts of the image without corners" in titles(corner)
    assert "lower edge" in Case(corner, False).empty
    assert "Few photos" in titles(replace(found, photos=found.photos[:6]))
    doubt = replace(found, halves=np.full((5, 2), 2.0))
    assert "Halves of the photos disagree" in titles(doubt)
    shaken = np.where(np.arange(10) == 4, 0.5, 0.01)
    assert "Photos with large errors of their own" in titles(
        replace(found, component=shaken)
    )
    left = replace(found, left_out={"IMG_1.jpg": "no marker is seen"})
    (one,) = [f for f in Case(left, False).findings if f.title == "Photos left out"]
    assert one.words == "IMG_1.jpg: no marker is seen."
