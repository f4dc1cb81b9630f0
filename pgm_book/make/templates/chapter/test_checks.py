"""Exercise feedback of chapter NUMBER: right answers pass, each slip is named."""

import pytest

from pgm_book.chFILE import checks as chapterNUMBER
from pgm_book.common.checks import CheckFailed


def test_right_answers_pass(capsys):
    chapterNUMBER.ground_size(lambda p, H, c: p / c * H)
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
        chapterNUMBER.ground_size(slip)
