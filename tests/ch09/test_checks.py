"""Exercise feedback of chapter 9: right answers pass, each slip is named."""

from unittest import mock

import numpy as np
import pytest

from pgm_book.ch09 import checks as chapter9
from pgm_book.common.checks import CheckFailed
from pgm_book.program import surface as book
from pgm_book.program.adjustment import adjust
from pgm_book.program.bundle import without_lens
from pgm_book.program.camera import derivatives, project
from pgm_book.program.orientation import resection
from pgm_lab import rotation
from tests.common.slips import unnamed

FIRST = np.repeat([1, 0], 3)  # the base, without the angles
RIGHT = ("flat_board", "new_photo", "y_parallaxes", "base_length", "surface_point")


@pytest.mark.parametrize("name", RIGHT)
def test_the_book_s_own_passes(name, capsys):
    getattr(chapter9, name)(getattr(book, name))
    assert capsys.readouterr().out.startswith(f"✓ {name}:")


@pytest.mark.parametrize("name", RIGHT)
def test_what_is_empty_is_not_judged(name):
    for nothing in (..., lambda *_: None):
        with pytest.raises(CheckFailed, match="Your turn!"):
            getattr(chapter9, name)(nothing)


def test_lists_pass(capsys):
    chapter9.flat_board(lambda *a: [np.array(p).tolist() for p in book.flat_board(*a)])
    chapter9.surface_point(lambda *a: book.surface_point(*a).tolist())
    chapter9.y_parallaxes(lambda *a: list(book.y_parallaxes(*a)))
    assert capsys.readouterr().out.count("✓") == 3


def flat(xy, camera, exteriors, grid, sign=-1, lens=True, moves=True, C=True, s=True):
    def misclosures(u):
        photos = u[10:].reshape(-1, 6)
        v = [
            project(e, grid, u[0]) - (without_lens(p, u[:10]) if lens else p)
            for e, p in zip(photos, xy)
        ]
        return np.ravel(v)

    u = np.concatenate([camera, exteriors.ravel()])
    for _ in range(6):
        A = derivatives(misclosures, u)
        A = A + (0 if lens else 1e-9 * np.random.default_rng(1).normal(size=A.shape))
        x, _, sigma0, Q = adjust(A, np.ones(len(A)), sign * misclosures(u))
        u = u + moves * x
    return u[:10], (sigma0**2 if C else 1) * Q[:10, :10], sigma0 if s else sigma0**2


@pytest.mark.slow
def test_a_slip_of_the_flat_board_is_named():
    def changed(**slip):
        return lambda *case: flat(*case, **slip)

    right = book.flat_board(*chapter9._photos())

    def held(xy, camera, exteriors, grid):  # the stations stay where they were
        A = np.zeros((xy.size, 40))
        return adjust(A, np.ones(len(A)), xy.ravel())

    def untouched(xy, camera, exteriors, grid):
        return camera, 0 * np.eye(10), 0

    slips = [
        (held, r"v\[i\] is still open"),
        (lambda xy, *rest: flat(xy[:, 1:], *rest), "`project` takes its station"),
        (untouched, "adjusts nothing yet. Your turn!"),
        (changed(moves=False), "stay at their start"),
        (changed(C=False), "sigma0 squared times Q"),
        (changed(s=False), "sigma0 is not that"),
        (lambda *a: right[0], "must return the camera"),
        (lambda *a: (*right[:2], np.ones(3)), "got shapes"),
        (
            lambda *a: (right[0] * 1.001, *right[1:]),
            "end elsewhere",
        ),
        (
            lambda *a: (right[0] + 9, *right[1:]),
            "lead away",
        ),
    ]
    assert unnamed(chapter9.flat_board, slips) == []


def left_of(xy, camera, board, start):
    ideal = without_lens(xy, camera)
    exterior = resection(start, ideal, board, camera[0])[0]
    return project(exterior, board, camera[0]) - ideal


def test_a_slip_of_a_new_photo_is_named():
    slips = [
        (lambda *a: np.sqrt(np.mean(np.sum(left_of(*a) ** 2, 1))), "of distances"),
        (lambda *a: np.mean(left_of(*a) ** 2), "mean square: its root"),
        (lambda *a: np.mean(left_of(*a)), "signs, which cancel"),
        (lambda *a: np.mean(np.abs(left_of(*a))), "absolute values"),
        (
            lambda *a: np.sqrt(np.sum(left_of(*a) ** 2) / (2 * len(a[0]) - 6)),
            "without a redundancy",
        ),
        (
            lambda *a: np.sqrt(
                np.mean((left_of(*a) + without_lens(*a[:2]) - a[0]) ** 2)
            ),
            "corrected image points",
        ),
        (lambda *a: 1000 * book.new_photo(*a), "in pixels: mm"),
        (lambda *a: 2 * book.new_photo(*a), "is not the root mean square"),
    ]
    assert unnamed(chapter9.new_photo, slips) == []


def parallaxes(e, left, right, c, turns, axis=1):
    R, S = turns(*book.frame(e))
    first, second = np.insert(left, 2, -c, 1) @ R.T, np.insert(right, 2, -c, 1) @ S.T
    return -c * (first[:, axis] / first[:, 2] - second[:, axis] / second[:, 2])


def test_a_slip_of_the_y_parallaxes_is_named():
    def turned(turns, axis=1):
        return lambda *case: parallaxes(*case, turns, axis)

    def rays_only(e, left, right, c):
        M, N = book.frame(e)
        first, second = np.insert(left, 2, -c, 1), np.insert(right, 2, -c, 1) @ M
        return (first @ N.T)[:, 1] - (second @ N.T)[:, 1]

    def plus_c(e, left, right, c):
        M, N = book.frame(e)
        first, second = np.insert(left, 2, -c, 1), np.insert(right, 2, c, 1) @ M
        (_, y, z), (_, other, far) = N @ first.T, N @ second.T
        return -c * (y / z - other / far)

    slips = [
        (lambda *a: -book.y_parallaxes(*a), "the sign"),
        (turned(lambda M, N: (N, N @ M.T), 0), "x parallaxes"),
        (turned(lambda M, N: (N, N @ M)), "transpose of M"),
        (turned(lambda M, N: (N, N)), "M is missing"),
        (turned(lambda M, N: (N, M.T)), "N is missing"),
        (turned(lambda M, N: (N, N.T @ M.T)), "here it is its transpose"),
        (turned(lambda M, N: (N, M.T @ N)), "first M goes back"),
        (plus_c, "a ray of the photo is"),
        (lambda *a: np.abs(book.y_parallaxes(*a)), "a parallax has a sign"),
        (rays_only, "not yet image points"),
        (lambda *a: book.y_parallaxes(*a) / a[3], "wanted in mm"),
        (lambda *a: book.y_parallaxes(*a)[:, None], r"shape \(9,\)"),
        (lambda *a: a[1][:, 1] - a[2][:, 1], "it is not y' minus y''"),
    ]
    assert unnamed(chapter9.y_parallaxes, slips) == []


def test_a_slip_of_the_base_is_named():
    def turned_back(e, *rest):
        M = rotation.matrix(*e[3:]).T
        return book.base_length(np.append(e[:3], rotation.angles(M)), *rest)

    def unit(e, *rest):
        return book.base_length(e, *rest) / np.linalg.norm(e[:3])

    slips = [
        (unit, "that is the X of the base"),
        (lambda e, *rest: np.linalg.norm(e[:3]) / unit(e, *rest), "upside down"),
        (lambda e, *rest: np.linalg.norm(e[:3]), "how many metres is a unit"),
        (lambda e, *rest: rest[3] / unit(e, *rest), "distance in the model"),
        (turned_back, "M leads to the image"),
        (lambda *a: book.base_length(*a) / a[4], "the distance takes no part"),
        (lambda e, *rest: book.base_length(e * FIRST, *rest), "M is missing"),
        (lambda e, *rest: 0.9 * book.base_length(e, *rest), "it is not the base"),
    ]
    assert unnamed(chapter9.base_length, slips) == []


def test_a_slip_of_a_point_of_the_surface_is_named():
    def changed(*factors):
        return lambda *a: book.surface_point(*a) * factors

    def across(*a):
        point = book.surface_point(*a)
        return point * (1, 1, 1, a[4] / -point[2])

    def upside_down(*a):
        point = book.surface_point(*a)
        return point * (1, 1, 1, (a[4] / point[2]) ** 2)

    def from_r(least):
        def point(*a):
            with mock.patch.object(book, "LEAST", least):
                return book.surface_point(*a)

        return point

    def always(pair, column, row, span, base, c, pixel_size, sigma_px):
        point = book.surface_point(pair, column, row, span, base, c, pixel_size, 0.2)
        return np.where(np.isnan(point), 1.0, point)

    slips = [
        (changed(1, 1, -1, 1), "looks along -z"),
        (changed(1, -1, 1, 1), "rows count downwards"),
        (changed(1, 1, 1, 5), "of a whole pixel"),
        (across, "H/B is missing"),
        (changed(*3 * [0.001], 1), "the disparity times the pixel size"),
        (changed(1.1, 1, 1, 1), "your `best_disparity`"),
        (upside_down, "H first, then B"),
        (from_r(0.7), "below 0.8"),
        (from_r(0.9), "above there is a point"),
        (lambda *_: np.full(4, np.nan), "which way is r compared"),
        (always, "below 0.8"),
        (lambda *a: book.surface_point(*a)[:3], r"shape \(4,\)"),
    ]
    assert unnamed(chapter9.surface_point, slips) == []
