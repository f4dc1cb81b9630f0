"""Exercise feedback of chapter 5: right answers pass, each slip is named."""

import numpy as np
import pytest

from pgm_book.ch05 import checks as chapter5
from pgm_book.common.checks import CheckFailed
from pgm_book.program import adjustment as least_squares
from pgm_book.program import camera as textbook
from pgm_book.program import orientation as lines
from pgm_lab import rotation
from tests.common.slips import unnamed


def image(M_of=lambda e: rotation.matrix(*e[3:]), sign=-1, origin=True):
    def projected(exterior, points, c):
        U, V, W = M_of(exterior) @ (points - origin * exterior[:3]).T
        return sign * c * np.column_stack([U / W, V / W])

    return projected


image_mm, ground_m = np.ones((5, 2)), np.ones((5, 3))  # as the example's are named


def unsigned(exterior, points, c):
    U, V, W = rotation.matrix(*exterior[3:]) @ (points - exterior[:3]).T
    return c * np.column_stack([U, V]) / np.abs(W)[:, None]


def transposed(exterior):
    return rotation.matrix(*exterior[3:]).T


def nearest(stations, directions, unit=True):
    d = directions
    if unit:
        d = d / np.linalg.norm(d, axis=1, keepdims=True)
    across = np.eye(3) - d[:, :, None] * d[:, None, :]
    return np.linalg.solve(
        across.sum(0), np.einsum("nij,nj->i", across, np.asarray(stations))
    )


def differences(function, at, step=1e-6, back=1, twice=2.0, as_float=True):
    columns = []
    for k in range(len(at)):
        there, behind = (np.array(at, dtype=float if as_float else None) for _ in "12")
        there[k] += step
        behind[k] -= back * step
        change = np.ravel(function(there) - function(behind))
        columns.append(change / (twice * step))
    return np.column_stack(columns)


def together(function, at):
    """All unknowns are moved, each a step more than the one before."""
    there, behind, columns = np.array(at, dtype=float), np.array(at, dtype=float), []
    for k in range(len(at)):
        there[k] += 1e-6
        behind[k] -= 1e-6
    for _ in range(len(at)):
        columns.append(np.ravel(function(there) - function(behind)) / 2e-6)
    return np.column_stack(columns)


def loop(
    start,
    image,
    points,
    c,
    steps=10,
    sign=1,
    add=True,
    sd_of=None,
    column=True,
    out=None,
    image_of=textbook.project,
):
    """The resection of the lesson, with slips."""
    exterior = np.array(start, dtype=float)
    for _ in range(steps):
        A = textbook.derivatives(lambda e: image_of(e, points, c), exterior)
        missing = sign * (image - image_of(exterior, points, c))
        missing = np.ravel(missing) if column else missing
        x, _, sigma0, Q = least_squares.adjust(A, np.ones(len(A)), missing)
        exterior = exterior + x if add else exterior
    sd = (sd_of or (lambda s, Q: s * np.sqrt(np.diag(Q))))(sigma0, Q)
    exterior[3:] = exterior[3:] if out is None else out(exterior[3:])
    return exterior, sd


def plain(exterior, points, c):
    """As a reader projects: what lies behind the camera is not refused."""
    U, V, W = rotation.matrix(*exterior[3:]) @ (points - exterior[:3]).T
    return np.column_stack([-c * U / W, -c * V / W])


def test_right_answers_pass(capsys):
    chapter5.project(textbook.project)
    chapter5.project(image())
    chapter5.project(lambda e, p, c: image()(e, p, c).tolist())
    chapter5.derivatives(textbook.derivatives)
    chapter5.derivatives(differences)
    chapter5.derivatives(lambda f, at: differences(f, at, 1e-5))
    chapter5.resection(lines.resection)
    chapter5.resection(loop)
    chapter5.resection(lambda *a: np.array(loop(*a)))
    chapter5.intersection(nearest)
    chapter5.relative(lines.relative)
    chapter5.relative(lambda *a: lines.relative(*a).tolist())
    assert capsys.readouterr().out.count("✓") == 12


def test_slip_in_the_projection_is_named():
    slips = [
        (image(sign=1), "the sign: W is negative"),
        (image(transposed), "M is transposed"),
        (image(lambda e: rotation.matrix(*np.radians(e[3:]))), "radians already"),
        (image(lambda e: np.eye(3)), "M is missing"),
        (image(origin=False), "perspective centre is not subtracted"),
        (lambda e, p, c: image()(e, p, c)[:, ::-1], "x and y are exchanged"),
        (lambda e, p, c: image()(e, p, c) * (1, -1), "y points up"),
        (lambda e, p, c: image()(e, p, c) / c, "principal distance is missing"),
        (unsigned, "W keeps its sign"),
        (lambda e, p, c: image()(e, p, c).T, "must return shape"),
        (lambda e, p, c: image()(e, p, c) + 0.1, "are not imaged there"),
        (lambda e, p, c: None, "returns nothing yet"),
        (..., "is not a function yet"),
    ]
    assert unnamed(chapter5.project, slips) == []


def test_slip_in_the_derivatives_is_named():
    slips = [
        (lambda f, at: -differences(f, at), "the sign: there minus back"),
        (lambda f, at: differences(f, at, twice=1), "there are two steps"),
        (lambda f, at: differences(f, at, back=0), "each is counted once"),
        (lambda f, at: differences(f, at, back=0, twice=1), "nearly: the error"),
        (lambda f, at: differences(f, at, 1e-2), "nearly: the error"),
        (lambda f, at: 1e-6 * differences(f, at), "not divided by the interval"),
        (lambda f, at: 2e-6 * differences(f, at), "not divided by the interval"),
        (lambda f, at: 0 * differences(f, at), "nothing moves"),
        (together, "move one unknown at a time"),
        (lambda f, at: differences(f, at).T, "must return shape"),
        (lambda f, at: differences(f, at) + 0.5, "not the changes of the function"),
        (lambda f, at: None, "returns nothing yet"),
    ]
    assert unnamed(chapter5.derivatives, slips) == []


def test_what_is_not_filled_yet_is_said_in_plain_words():
    def empty(function, at):
        return np.column_stack([])

    def singular(stations, directions):
        return np.linalg.solve(np.zeros((3, 3)), np.zeros(3))

    def dots(start, image, points, c):
        return least_squares.adjust(..., np.ones(10), ...)

    with pytest.raises(CheckFailed, match="no column yet. Your turn!"):
        chapter5.derivatives(empty)
    with pytest.raises(CheckFailed, match="Is every ray added to it"):
        chapter5.intersection(singular)
    with pytest.raises(CheckFailed, match="still `...`. Your turn!"):
        chapter5.resection(dots)


def test_a_table_of_answers_makes_one_column():
    def unraveled(function, at):
        found = differences(function, at)
        return found if np.ndim(function(at)) == 1 else found.reshape(2, 2, -1)

    with pytest.raises(CheckFailed, match="with np.ravel"):
        chapter5.derivatives(unraveled)


@pytest.mark.parametrize("order", ["F", "T"])
def test_a_table_is_read_row_by_row(order):
    def by_columns(function, at):
        def turned(x):
            table = np.asarray(function(x))
            return np.ravel(table.T) if order == "T" else np.ravel(table, order="F")

        return differences(turned, at)

    with pytest.raises(CheckFailed, match="one row of the table after the other"):
        chapter5.derivatives(by_columns)


def test_a_step_in_proportion_to_the_unknown_is_none_at_zero():
    def proportional(function, at):
        columns = []
        for k, value in enumerate(at):
            there, behind = np.array(at, dtype=float), np.array(at, dtype=float)
            there[k] += 1e-6 * value
            behind[k] -= 1e-6 * value
            change = np.ravel(function(there) - function(behind))
            columns.append(change / (2e-6 * value))
        return np.column_stack(columns)

    with pytest.raises(CheckFailed, match="an unknown may be 0"):
        chapter5.derivatives(proportional)


def test_whole_numbers_are_moved_as_well():
    with pytest.raises(CheckFailed, match="whole numbers|UFuncTypeError|two steps"):
        chapter5.derivatives(lambda f, at: differences(f, at, as_float=False))


def test_slip_in_the_resection_is_named():
    slips = [
        (lambda *a: loop(*a, steps=1), "that is one step"),
        (lambda *a: loop(*a, add=False), "exterior is still the start"),
        (lambda *a: loop(*a, sign=-1), "lead away"),
        (lambda *a: loop(*a, sign=-1, image_of=plain), "lead away"),
        (lambda *a: loop(*a, steps=2), "comes near, but does not converge"),
        (lambda *a: loop(*a, column=False), "np.ravel makes it of a table"),
        (lambda *a: textbook.derivatives(np.ones(3), a[0]), "needs a function"),
        (lambda *a: textbook.derivatives(textbook.project, a[0]), "needs a functi"),
        (lambda *a: loop(a[0], image_mm, *a[2:]), "not from the example: image_mm"),
        (lambda *a: loop(*a[:2], (lambda: ground_m)(), a[3]), "example: ground_m"),
        (lambda *a: loop(*a[:3], 152.916), "not from the example: 152.916"),
        (lambda *a: loop(*a, out=np.degrees), "wanted in radians"),
        (lambda *a: loop(*a, sd_of=lambda s, Q: np.sqrt(np.diag(Q))), "by sigma0"),
        (
            lambda *a: loop(*a, sd_of=lambda s, Q: s**2 * np.diag(Q)),
            "those are variances",
        ),
        (lambda *a: loop(*a, sd_of=lambda s, Q: s * np.diag(Q)), "does not follow"),
        (lambda *a: (loop(*a)[0], ...), "is still `...`"),
        (lambda *a: dict.get({}, "x")["x"], "do exercises 5.1 and 5.2"),
    ]
    assert unnamed(chapter5.resection, slips) == []


def across(d):
    return np.eye(3) - np.outer(d, d)


def summed(matrix_of, right_of=None):
    """The loop of the lesson with another matrix, on either side."""

    def point(stations, directions):
        units = [d / np.linalg.norm(d) for d in directions]
        matrix = sum(matrix_of(d) for d in units)
        right = sum((right_of or matrix_of)(d) @ s for s, d in zip(stations, units))
        return np.linalg.solve(matrix, right)

    return point


def test_loop_over_the_rays_passes():
    chapter5.intersection(summed(across))


def all_by_one(stations, directions):
    """Each direction divided by the norm of the whole array."""
    units = directions / np.linalg.norm(directions)
    matrices = [across(d) for d in units]
    right = sum(P @ s for P, s in zip(matrices, stations))
    return np.linalg.solve(sum(matrices), right)


def midpoint(stations, directions):
    """The answer for two rays, given for the first two of any number."""
    return nearest(stations[:2], directions[:2])


def test_slip_in_the_intersection_is_named():
    slips = [
        (lambda s, d: nearest(s, d, unit=False), "make it a unit vector"),
        (midpoint, "is not least"),
        (lambda s, d: nearest(s, d) + (len(s) == 2), "two of the rays alone"),
        (lambda s, d: s.mean(axis=0), "the mean of the stations"),
        (summed(lambda d: np.outer(d, d)), "that is the part along the ray"),
        (summed(lambda d: np.eye(3) + np.outer(d, d)), "look at the sign"),
        (summed(lambda d: np.eye(3) - d * d), "d \\* d only its own"),
        (summed(lambda d: np.eye(3) - d @ d), "not a number"),
        (summed(across, lambda d: np.eye(3)), "each station is multiplied by its P"),
        (summed(across, lambda d: -across(d)), "the sign of the right side"),
        (all_by_one, "by its own length"),
        (lambda s, d: s[-1] + 20 * d[-1], "only the last ray counts"),
        (lambda s, d: nearest(s, -d) + 1, "that meet exactly"),
    ]
    assert unnamed(chapter5.intersection, slips) == []


def test_wrong_point_from_unit_vectors_is_not_told_to_use_them():
    with pytest.raises(CheckFailed) as failed:
        chapter5.intersection(lambda s, d: nearest(s, d) + 1)
    assert "that meet exactly" in str(failed.value)
    assert "unit vector" not in str(failed.value)


def test_rays_of_a_line_have_no_sign():
    chapter5.intersection(lambda s, d: nearest(s, -d))


def wrong_relative(function):
    """relative with a slip: `function` changes the right answer."""
    return lambda left, right, c: function(lines.relative(left, right, c))


def of_some(rows):
    return lambda left, right, c: lines.relative(left[rows], right[rows], c)


def test_slip_in_the_relative_orientation_is_named():
    slips = [
        (wrong_relative(lambda e: np.append(e[:3] / np.linalg.norm(e[:3]), e[3:])),
         "X0 is 1"),
        (wrong_relative(lambda e: np.append(e[:3], np.degrees(e[3:]))), "in radians"),
        (lambda left, right, c: lines.relative(right, left, c), "left photo is held"),
        (lambda left, right, c: lines.relative(left, right, -c), "minus z axis"),
        (wrong_relative(lambda e: np.append(e[:3], rotation.angles(transposed(e)))),
         "a ray goes back"),
        (wrong_relative(lambda e: e + [0, 1e-4, 0, 0, 0, 0]), "do not lie in one"),
        (of_some(slice(10)), "it is left out"),
        (of_some(slice(-1)), "it is left out"),
        (of_some(slice(1, None)), "it is left out"),
        (wrong_relative(lambda e: e[1:]), "must return shape"),
        (wrong_relative(lambda e: e[:, None]), r"shape \(6,\) here; got \(6, 1\)"),
        (..., "relative is not a function yet"),
    ]  # fmt: skip
    assert unnamed(chapter5.relative, slips) == []
