"""Feedback on the exercises of the case of forty coordinates."""

from functools import partial

import numpy as np

from pgm_book.ch01 import case_checks
from tests.common.slips import unnamed


def line(pixel, mm):
    slope, shift = np.polyfit(pixel, mm, 1)
    return np.array([slope, -shift / slope])


def table(photo, size, px, decimals=6, digits=7, y=1, half=0.0):
    centre = np.array(size) / 2 - 0.5 + half
    return np.round(np.round(photo, decimals) / np.array(px) * (1, y) + centre, digits)


def test_right_answers_pass(capsys):
    case_checks.size_and_centre(lambda pixel, mm: tuple(line(pixel, mm)))
    case_checks.to_table(table)
    assert capsys.readouterr().out.count("✓") == 2


def test_slip_in_size_and_centre_is_named():
    slips = [
        (lambda p, m: line(p, m)[::-1], "exchanged"),
        (lambda p, m: np.polyfit(p, m, 1), "at which pixel is the line zero"),
        (lambda p, m: line(p, m) * (1, -1), "sign of the centre"),
        (lambda p, m: line(p, m) ** (-1, 1), "pixels per millimetre"),
        (lambda p, m: line(p, m) * (1000, 1), "in micrometres"),
        (lambda p, m: line(p, m) * (1e-3, 1), "in metres"),
        (lambda p, m: np.polyfit(m, p, 1), "the other way round"),
        (lambda p, m: np.polyfit(m, p, 1) ** (-1, 1), "the other way round"),
        (lambda p, m: line(p, m) + (0, 0.5), "half a pixel"),
        (lambda p, m: line(p, m).round(4), "rounded"),
        (lambda p, m: line(p, m) * 2, "all twenty points"),
    ]
    assert unnamed(case_checks.size_and_centre, slips) == []


def test_slip_in_to_table_is_named():
    slips = [
        ({"decimals": 15}, "not rounded to six decimals"),
        ({"decimals": 5}, "Table 4.2 has five decimals"),
        ({"digits": 15}, "Table 4.1 has seven decimals"),
        ({"y": -1}, "the sign of y"),
        ({"half": 0.5}, "half a pixel"),
        ({"half": 7.0}, "round to six decimals"),
    ]
    assert (
        unnamed(lambda slip: case_checks.to_table(partial(table, **slip)), slips) == []
    )
