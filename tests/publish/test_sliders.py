"""Sliders and menus of the lessons in JupyterLab: real keys, and what follows them."""

import re

import matplotlib.pyplot as plt
import nbformat
import pytest
from IPython.utils.capture import capture_output

from pgm_book.ch01 import figures as target
from pgm_book.chA1 import figures as levelling
from pgm_book.common import ledger
from pgm_lab.plot import STYLE, basic
from tests.publish.conftest import CHAPTERS
from tests.publish.lab import LOADED, RUN, another, chosen, run, scroll_until, shows

LEFT, RIGHT = "ArrowLeft", "ArrowRight"
STYLED = "plt.style.use"
TARGET, LEVELLING = "01_pixel_to_photo", "A1_least_squares_adjustment"
BUNDLE = "06_self_calibrating_bundle_adjustment"
OBSERVED = ["observed = np.array", "measured = "]
# Of each lesson: some of its cells, each by a text in it; which of them has the
# sliders, how many; keys on some of these; then the values of all, and the figure.
SLIDERS = {
    "02_normalized_cross_correlation": (
        [STYLED, "by_hand("],
        (1, 3),
        [(0, RIGHT), (2, LEFT)],
        ["320", "318", "19"],
        "template of 19 px at (320, 318)",
    ),
    "03_least_squares_matching": (
        [STYLED, "def meadow(", "by_hand("],
        (2, 3),
        [(0, RIGHT), (2, LEFT)],
        ["-3", "-4", "-1"],
        "",
    ),
    "04_rotation_matrices": (
        [STYLED, "by_hand()"],
        (1, 3),
        [(2, RIGHT), (0, LEFT)],
        ["-5", "0", "5"],
        "ω = −5°, φ = 0°, κ = 5°",
    ),
    "05_intersection": (
        [STYLED, "base_by_hand("],
        (1, 1),
        [(0, RIGHT), (0, RIGHT)],
        ["80"],
        "base 80 m, rays that meet at 37 degrees",
    ),
}
CELLS = {name: texts for name, (texts, *_) in SLIDERS.items()} | {
    TARGET: [STYLED, "target_by_hand()"],
    BUNDLE: [STYLED, "which_photos("],
    LEVELLING: [*OBSERVED, "blunder_by_hand"],
}


@pytest.fixture(scope="module")
def work(tmp_path_factory):
    """The folder that the lab opens: chosen cells of each lesson, and the ledger."""
    folder = tmp_path_factory.mktemp("lab") / "work"
    folder.mkdir()
    for name, texts in CELLS.items():
        nbformat.write(chosen(CHAPTERS[name], texts), folder / f"{name}.ipynb")
    (folder / "A2_verdicts.ipynb").write_bytes(CHAPTERS["A2_verdicts"].read_bytes())
    return folder


@pytest.mark.parametrize("name", SLIDERS)
def test_keys_on_the_sliders_change_the_figure(lab, name):
    """The picture of the cell has to change with each key."""
    _, (cell, count), keys, wanted, said = SLIDERS[name]
    page = lab(name)
    run(page)
    sliders = page.locator(".jupyter-widgets .noUi-handle")
    sliders.nth(count - 1).wait_for(timeout=LOADED)
    assert sliders.count() == count
    picture = page.locator(".jp-Cell").nth(cell).locator(".jp-OutputArea img").first
    picture.wait_for(timeout=LOADED)
    before = picture.get_attribute("src")
    for k, key in keys:
        sliders.nth(k).focus()
        page.keyboard.press(key)
        before = another(page, picture, before)
    values = page.locator(".jupyter-widgets .widget-readout").all_inner_texts()
    assert [value.replace("−", "-") for value in values] == wanted
    alt = picture.get_attribute("alt")
    assert alt is None or said in alt


def test_the_network_of_lesson_6_follows_its_list_of_photos(lab):
    page = lab(BUNDLE)
    run(page)
    network = page.locator(".jp-Cell").last.locator(".jp-OutputArea img").first
    network.wait_for(timeout=LOADED)
    before = network.get_attribute("src")
    listed = page.locator(".jupyter-widgets select")
    listed.select_option(label=["1", "4", "6", "7", "8"])
    another(page, network, before)


@pytest.fixture
def drawn(monkeypatch):
    """A function that gives what a figure draws for some values of its sliders."""

    def of_sliders(module, show):
        held, shown = {}, []
        monkeypatch.setattr(module, "interact", lambda f, **_: held.update(draw=f))
        with capture_output(), plt.rc_context():
            show()
        monkeypatch.setattr(basic, "publish_display_data", lambda d, _: shown.append(d))

        def picture(said, *values):
            with plt.rc_context(STYLE):
                held["draw"](*values)
            assert said in shown[-1]["text/plain"]
            return shown[-1]["image/png"]

        return picture

    return of_sliders


def test_the_target_of_lesson_1_is_the_picture_of_its_values(lab, drawn):
    wanted = drawn(target, target.target_by_hand)
    page = lab(TARGET)
    run(page)
    handles = page.locator(".widget-slider .noUi-handle")
    handles.first.wait_for(timeout=LOADED)
    handles.first.scroll_into_view_if_needed()
    image = page.locator(".jp-OutputArea", has=handles.first).locator("img").last
    said = "moved by {} px, background 0"
    assert shows(page, image, wanted(said.format(4), 21, 4, 0))
    handles.nth(1).focus()
    for _ in range(2):
        page.keyboard.press(LEFT)
    assert shows(page, image, wanted(said.format(2), 21, 2, 0))


def test_the_blunder_of_lesson_a1_follows_its_list_and_its_slider(lab, drawn):
    names: dict = {}
    with capture_output(), plt.rc_context():
        for cell in chosen(CHAPTERS[LEVELLING], OBSERVED).cells:
            exec(cell.source, names)
    data = [names[n] for n in ("A", "p", "measured")]
    wanted = drawn(
        levelling, lambda: levelling.blunder_by_hand(*data, 0.002, names["lines"])
    )
    page = lab(LEVELLING)
    run(page)
    choice = page.locator(".widget-dropdown select").first
    choice.wait_for(timeout=LOADED)
    choice.scroll_into_view_if_needed()
    image = page.locator(".jp-OutputArea", has=choice).locator("img").last
    assert shows(page, image, wanted("+20 mm in AB", "AB", 20))
    choice.select_option("DE")
    assert shows(page, image, wanted("+20 mm in DE", "DE", 20))
    page.locator(".widget-slider .noUi-handle").first.click()
    for _ in range(4):  # steps of 2 mm
        page.keyboard.press(LEFT)
    assert shows(page, image, wanted("+12 mm in DE", "DE", 12))


def test_a_choice_in_the_menus_filters_the_ledger(lab):
    page = lab("A2_verdicts")
    run(page)
    menus = page.locator(".widget-dropdown select")
    scroll_until(page, lambda: menus.count() == 3)
    area = page.locator(".jp-OutputArea", has=menus.first).first
    for menu, value in ((0, "Harintaka 2020"), (2, "not derivable")):
        menus.nth(menu).select_option(label=value)
    rows = ledger.verdicts(source="Harintaka 2020", verdict="not derivable")
    said = f"^{len(rows)} verdicts: Harintaka 2020, not derivable$"
    table = area.locator("table.pgm-table")
    table.locator("caption").filter(has_text=re.compile(said)).wait_for(timeout=RUN)
    assert table.locator("tbody tr").count() == len(rows)
