"""Exercise feedback of chapter 7: right answers pass, each slip is named."""

import pytest

from pgm_lab.checks import CheckFailed, chapter7


def test_right_answers_pass(capsys):
    chapter7.ground_size(lambda p, H, c: p / c * H)
    assert capsys.readouterr().out.count("✓") == 1


@pytest.mark.parametrize(
    ("slip", "hint"),
    [
        (lambda p, H, c: c / (p * H), "upside down"),
        (lambda p, H, c: 100 * p * H / c, "centimetres"),
        (lambda p, H, c: 1000 * p * H / c, "millimetres"),
        (lambda p, H, c: p * c / H, "exchanged"),
        (lambda p, H, c: p + H + c, "two triangles"),
    ],
)
def test_each_slip_is_named(slip, hint):
    with pytest.raises(CheckFailed, match=hint):
        chapter7.ground_size(slip)
