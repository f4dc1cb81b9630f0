"""The call that is recommended along rows, against OpenCV's block matching."""

import cv2
import numpy as np
import pytest

from pgm_lab import datasets, ncc

LARGEST = 80  # px of parallax that both search


def stereo(n):
    """Middlebury's motorcycle: photos, points of the left one, their parallaxes."""
    pair = datasets.motorcycle()
    margin = 30
    inner = np.isfinite(pair.disparity)
    inner[:margin] = inner[-margin:] = inner[:, :margin] = inner[:, -margin:] = False
    row, column = np.nonzero(inner)
    some = np.random.default_rng(0).choice(len(row), n, replace=False)
    row, column = row[some], column[some]
    points = np.column_stack([column, row]).astype(float)
    left, right = (np.rint(grey).astype(np.uint8) for grey in (pair.left, pair.right))
    return left, right, points, pair.disparity[row, column]


def along_rows(left, right, points):
    """As the docstring of `ncc.match` recommends."""
    row = points[:, 1]
    return ncc.match(
        *(left, right, points, points - [LARGEST / 2, 0], 9, (11, LARGEST + 9)),
        *(0.7, 0.95, "parabola"),
        lines=np.column_stack([0 * row, 0 * row + 1, -row]),
        distance=0.5,
        back=0.75,
    )


def shares(parallax, found, truth):
    """Share of points that are found and right, and of the found that are wrong."""
    right = found & (np.abs(parallax - truth) <= 1)
    return right.mean(), 1 - right.sum() / found.sum()


@pytest.fixture(scope="module")
def ours():
    """What both programs get, and the shares of the one that is recommended."""
    left, right, points, truth = stereo(4000)
    found = along_rows(left, right, points)
    parallax = points[:, 0] - found.points[:, 0]
    return left, right, points, truth, shares(parallax, found.accepted, truth)


@pytest.mark.parametrize("window", [9, 11, 15, 21])
def test_along_rows_as_many_are_right_as_of_stereobm_and_fewer_are_wrong(window, ours):
    """At least 0.95 times as many, with whatever window OpenCV works."""
    left, right, points, truth, (our_right, our_wrong) = ours
    column, row = points.astype(int).T
    disparity = cv2.StereoBM_create(LARGEST, window).compute(left, right)
    peer = disparity[row, column] / 16
    peer_right, peer_wrong = shares(peer, peer > 0, truth)
    assert our_right > 0.95 * peer_right
    assert our_wrong < peer_wrong
