"""The three angles of lesson 4 in JupyterLab: a real key turns the camera."""

from tests.publish.sliders import address, lab, lesson, moved, run, work

NAME = "04_rotation_matrices"
CELLS = ["plt.style.use", "by_hand()"]
__all__ = ["address", "lab", "lesson", "work"]


def test_a_key_on_a_slider_turns_the_camera_and_its_photo(lab):
    page = lab(NAME)
    run(page)
    values, picture = moved(page, 3, ((2, "ArrowRight"), (0, "ArrowLeft")))
    assert values == ["-5", "0", "5"]
    alt = picture.get_attribute("alt")
    assert alt is None or "ω = −5°, φ = 0°, κ = 5°" in alt
