"""The lens and the photos of lesson 6 in JupyterLab: real keys change them."""

from tests.publish.sliders import (
    LOADED,
    address,
    another,
    lab,
    lesson,
    moved,
    run,
    work,
)

NAME = "06_self_calibrating_bundle_adjustment"
CELLS = ["plt.style.use", "lens_by_hand(", "which_photos("]
__all__ = ["address", "lab", "lesson", "work"]


def test_keys_change_the_lens_and_the_list_of_photos(lab):
    page = lab(NAME)
    run(page)
    values, _ = moved(page, 2, [(1, "ArrowRight")], cell=1)
    assert values == ["3.00", "0.50"]

    network = page.locator(".jp-Cell").last.locator(".jp-OutputArea img").first
    network.wait_for(timeout=LOADED)
    before = network.get_attribute("src")
    page.locator(".jupyter-widgets select").select_option(
        label=["1", "4", "6", "7", "8"]
    )
    another(page, network, before)
