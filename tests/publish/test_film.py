"""The start of lesson 3's film in JupyterLab: real keys move and turn it."""

from tests.publish.sliders import address, lab, lesson, moved, run, work

NAME = "03_least_squares_matching"
CELLS = ["plt.style.use", "def meadow(", "by_hand("]
__all__ = ["address", "lab", "lesson", "work"]


def test_keys_on_the_sliders_move_and_turn_the_start_of_the_film(lab):
    page = lab(NAME)
    run(page)
    values, _ = moved(page, 3, ((0, "ArrowRight"), (2, "ArrowLeft")))
    assert values == ["-3", "-4", "-1"]
