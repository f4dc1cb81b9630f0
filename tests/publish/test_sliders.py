"""The sliders of the lessons in JupyterLab: real keys move them, the figure follows."""

import nbformat
import pytest

from tests.publish.sliders import ROOT, address, another, chosen, lab, moved, run
from tests.publish.test_lab import LOADED

__all__ = ["address", "lab"]

LEFT, RIGHT = "ArrowLeft", "ArrowRight"
# Of each lesson: some of its cells, each by a text in it; which of them has the
# sliders, how many; keys on some of these; then the values of all, and the figure.
SLIDERS = {
    "02_normalized_cross_correlation": (
        ["plt.style.use", "by_hand("],
        (1, 3),
        [(0, RIGHT), (2, LEFT)],
        ["320", "318", "19"],
        "template of 19 px at (320, 318)",
    ),
    "03_least_squares_matching": (
        ["plt.style.use", "def meadow(", "by_hand("],
        (2, 3),
        [(0, RIGHT), (2, LEFT)],
        ["-3", "-4", "-1"],
        "",
    ),
    "04_rotation_matrices": (
        ["plt.style.use", "by_hand()"],
        (1, 3),
        [(2, RIGHT), (0, LEFT)],
        ["-5", "0", "5"],
        "ω = −5°, φ = 0°, κ = 5°",
    ),
    "05_intersection": (
        ["plt.style.use", "base_by_hand("],
        (1, 1),
        [(0, RIGHT), (0, RIGHT)],
        ["80"],
        "base 80 m, rays that meet at 37 degrees",
    ),
    "06_self_calibrating_bundle_adjustment": (
        ["plt.style.use", "lens_by_hand(", "which_photos("],
        (1, 2),
        [(1, RIGHT)],
        ["3.00", "0.50"],
        "",
    ),
}


@pytest.fixture(scope="module")
def lesson():
    """A notebook, whose place tells where the package is."""
    return ROOT / "notebooks" / f"{next(iter(SLIDERS))}.ipynb"


@pytest.fixture(scope="module")
def work(lesson, tmp_path_factory):
    """The folder that the lab opens: the chosen cells of each lesson, not run."""
    folder = tmp_path_factory.mktemp("lab") / "work"
    folder.mkdir()
    for name, (texts, *_) in SLIDERS.items():
        path = lesson.with_name(f"{name}.ipynb")
        nbformat.write(chosen(path, texts), folder / path.name)
    return folder


@pytest.mark.parametrize("name", SLIDERS)
def test_keys_on_the_sliders_change_the_figure(lab, name):
    _, (cell, count), keys, wanted, said = SLIDERS[name]
    page = lab(name)
    run(page)
    values, picture = moved(page, count, keys, cell)
    assert values == wanted
    alt = picture.get_attribute("alt")
    assert alt is None or said in alt
    if "06" not in name:
        return
    network = page.locator(".jp-Cell").last.locator(".jp-OutputArea img").first
    network.wait_for(timeout=LOADED)
    before = network.get_attribute("src")
    listed = page.locator(".jupyter-widgets select")
    listed.select_option(label=["1", "4", "6", "7", "8"])
    another(page, network, before)
