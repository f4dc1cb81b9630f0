"""Figures of matrices show which blocks are filled, and the numbers themselves."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pgm_book.ch06 import case_figures as ch06_case_figures
from pgm_lab import bundle, plot
from pgm_lab.camera import BLOCKS, Camera, imaging

LENS = Camera(30.0, 0.2, -0.1, 2e-5, -3e-7, 2e-9, 3e-6, -4e-6).interior


@pytest.fixture(autouse=True)
def closed():
    yield
    plt.close("all")


def normal_equations(seen, interior, border):
    """The bordered normal matrix of convergent photos, and its Schur complement."""
    m, n = seen.shape
    rng = np.random.default_rng(3)
    points = rng.uniform(-1, 1, (n, 3))
    exteriors = np.column_stack(
        [rng.uniform(-1, 1, (m, 2)), np.full(m, 5.0), rng.uniform(-0.2, 0.2, (m, 3))]
    )
    photo, point = np.nonzero(seen)
    xy = rng.uniform(-9, 9, (len(photo), 2))
    _, _, by = imaging.misclosure(
        LENS, exteriors[photo], points[point], xy, "backward", BLOCKS
    )
    first = interior + 6 * m
    A = np.zeros((len(photo), 2, first + 3 * n))
    A[..., :interior] = by["interior"][..., :interior]
    ray = np.arange(len(photo))[:, None]
    A[ray, :, interior + 6 * photo[:, None] + np.arange(6)] = np.moveaxis(
        by["exterior"], 1, 2
    )
    A[ray, :, first + 3 * point[:, None] + np.arange(3)] = np.moveaxis(
        by["point"], 1, 2
    )
    A = A.reshape(-1, first + 3 * n)
    G = np.zeros((first + 3 * n, border))
    if border:
        G[first:] = bundle.motions(points, np.zeros(3)).reshape(7, -1).T
    N = np.block([[A.T @ A, G], [G.T, np.zeros((border, border))]])
    at = np.arange(first, first + 3 * n)
    rest = np.delete(np.arange(len(N)), at)
    coupling = N[np.ix_(rest, at)]
    schur = N[np.ix_(rest, rest)] - coupling @ np.linalg.solve(
        N[np.ix_(at, at)], coupling.T
    )
    return N, schur


@settings(max_examples=25, deadline=None)
@given(
    seen=arrays(bool, (4, 9)),
    interior=st.sampled_from([0, 3, 10]),
    border=st.sampled_from([0, 7]),
)
def test_blocks_are_those_of_a_real_normal_matrix_and_of_its_schur_complement(
    seen, interior, border
):
    seen[[0, 1, 2], :3] |= np.eye(3, dtype=bool)
    seen[3, 3] = True  # every photo sees a point
    seen[:2, 0] = seen[1:3, 1:] = True  # and every point lies in two photos
    matrices = normal_equations(seen, interior, border)
    for eliminated, N in zip((False, True), matrices):
        blocks = ch06_case_figures.normal_blocks(
            *np.nonzero(seen), interior, border, eliminated
        )
        # Rounding of the elimination leaves some 1e-13 of the largest entry of a row
        size = np.abs(N).max(axis=1)
        filled = np.abs(N) > 1e-11 * np.sqrt(np.outer(size, size))
        covered = np.zeros(N.shape, dtype=int)
        for i, j, rows, columns, _ in blocks:
            covered[i : i + rows, j : j + columns] += 1
            assert filled[i : i + rows, j : j + columns].any()
        assert covered.max() == 1  # no block twice
        assert not filled[covered == 0].any()


def test_normal_matrix_of_the_nine_photos_states_its_sizes():
    photo, point = np.divmod(np.arange(450), 50)
    (ax,) = ch06_case_figures.normal_matrix(photo, point).axes
    texts = [text.get_text() for text in ax.texts]
    heads = [text.split(",")[0] for text in texts if "filled" in text]
    assert heads == ["221 × 221", "71 × 71"]
    groups = ["interior 10", "9 × 6 photos", "50 × 3 points", "G 7"]
    assert [text for text in texts if text in groups] == [
        *groups, "interior 10", "9 × 6 photos", "G 7"
    ]  # fmt: skip
    # 10 x 214 twice less 10 x 10, the blocks of photos and points, rays, G
    share = (2 * 10 * 214 - 100 + 9 * 36 + 50 * 9 + 2 * 54 * 150 + 2 * 7 * 150) / 221**2
    assert f"221 × 221, {100 * share:.0f} % filled" in texts


def test_normal_matrix_draws_every_block():
    photo, point = np.array([(0, 0), (0, 1), (1, 1), (1, 2)]).T
    (ax,) = ch06_case_figures.normal_matrix(photo, point, border=0).axes
    drawn = sum(len(tiles.get_paths()) for tiles in ax.collections)
    expected = [
        ch06_case_figures.normal_blocks(photo, point, border=0, eliminated=eliminated)
        for eliminated in (False, True)
    ]
    assert drawn == sum(map(len, expected))
    legend = [text.get_text() for text in ax.get_legend().get_texts()]
    assert "datum G" not in legend
    assert "filled in" in legend


def test_spectrum_tells_what_a_tolerance_keeps():
    s = np.array([1e-3, 1e5, 10.0, 1e2, 0.0])
    fig = ch06_case_figures.spectrum({"N": s, "scaled": [1.0, 0.5]}, {"N": 1.0})
    (ax,) = fig.axes
    kept, lost, line, scaled, _ = ax.lines
    np.testing.assert_array_equal(kept.get_data(), [(1, 2, 3), (1e5, 1e2, 10)])
    np.testing.assert_array_equal(lost.get_data(), [(4,), (1e-3,)])  # log has no 0
    assert lost.get_markerfacecolor() == "none"
    assert set(line.get_ydata()) == {1.0}
    np.testing.assert_array_equal(scaled.get_ydata(), (1, 0.5))
    names = [text.get_text() for text in ax.get_legend().get_texts()]
    assert names == ["N: 3 of 5 kept", "scaled"]
    assert ax.get_yscale() == "log"
    fig = ch06_case_figures.spectrum({"N": s}, {"N": 1e-12})
    assert fig.axes[0].get_ylim()[0] < 1e-12  # the tolerance is seen
    assert kept.get_color() == plot.BLUE
