"""The template of lesson 2 in JupyterLab: a real key moves it over the photo."""

from tests.publish.sliders import address, lab, lesson, moved, run, work

NAME = "02_normalized_cross_correlation"
CELLS = ["plt.style.use", "by_hand("]
__all__ = ["address", "lab", "lesson", "work"]


def test_a_key_on_a_slider_moves_the_template_and_widens_it(lab):
    page = lab(NAME)
    run(page)
    values, picture = moved(page, 3, ((0, "ArrowRight"), (2, "ArrowLeft")))
    assert values == ["320", "318", "19"]
    alt = picture.get_attribute("alt")
    assert alt is None or "template of 19 px at (320, 318)" in alt
