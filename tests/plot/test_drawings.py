"""What every drawing has to do: to show all that it draws, and nothing twice over."""

import re
from itertools import combinations

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.quiver import Quiver, QuiverKey
from mpl_toolkits.mplot3d import Axes3D, proj3d
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection
from scipy.stats import chi2

from pgm_book.ch06 import case_figures as ch06_case_figures
from pgm_book.ch06 import figures as ch06_figures
from pgm_book.common import figures as common_figures
from pgm_lab import bundle, datasets, matching, plot, rotation
from pgm_lab.plot import _pixel
from pgm_lab.report import _figures
from tests.ch03 import test_film as film
from tests.matching import photos
from tests.networks import real

EXTERIOR = np.array([1.0, -2.0, 7.0, 0.3, -0.2, 0.8])
PHOTO, POINT = np.divmod(np.arange(450), 50)
STATUS = ["accepted"] * 45 + [*matching.STATUSES]
MATCHED = photos.result(len(STATUS), STATUS, shift=(-5.0, 1.0))
SECONDS = {"one": [0.01, 0.7], "another": [0.003, 1.4]}


@pytest.fixture(scope="module")
def result():
    return bundle.adjust(real())


FLAT = {
    "lens_curve": lambda r: plot.bundle.lens_curve(r, decentring=True),
    "all residual_vectors": plot.bundle.residual_vectors,
    "some residual_vectors": lambda r: plot.bundle.residual_vectors(r, [0, 5]),
    "standardized_histogram": plot.bundle.standardized_histogram,
    "film_strip": lambda _: common_figures.film_strip(
        film.LEFT,
        film.RIGHT,
        film.POINT,
        film.WINDOW,
        [film.START, film.TRUTH],
        ["start", "end"],
    ),
    "normal_matrix": lambda _: ch06_case_figures.normal_matrix(PHOTO, POINT),
    "normal_matrix of a known camera": lambda _: ch06_case_figures.normal_matrix(
        PHOTO[:60], POINT[:60], interior=0, border=0
    ),
    "correlation_matrix": ch06_case_figures.correlation_matrix,
    "spectrum": lambda _: ch06_case_figures.spectrum({"N": [5.0, 2, 0.5]}, {"N": 1.0}),
    "residuals_by_photo": lambda _: ch06_case_figures.residuals_by_photo(
        {"start": [0.13, 0.2], "adjusted": [3e-4, 2e-4]}
    ),
    "predicted_against_sampled": lambda _: ch06_case_figures.predicted_against_sampled(
        [2e-3, 5.0], {"free": [2.2e-3, 4.5], "wrong": [8e-3, 60.0]}, ["c", "X0"], 500
    ),
    "size_study": lambda _: ch06_case_figures.size_study(
        [450, 8e4], SECONDS, [3, 140], ["a", "b"]
    ),
    "side_by_side": lambda _: plot.matches.side_by_side(*photos.pair(), MATCHED),
    "parallaxes": lambda _: plot.matches.parallaxes(photos.pair()[0], MATCHED),
    "histograms": lambda _: plot.matches.histograms(MATCHED, threshold=0.7),
    "mean residuals of a report": lambda r: _figures.mean_residuals(r)[0],
}
IN_SPACE = {
    "seven_motions": lambda r: ch06_figures.seven_motions(r.exteriors, r.points),
    "network_3d": lambda r: ch06_figures.network_3d(
        r.exteriors, r.points, r.covariance_points
    ),
}


@pytest.fixture(autouse=True, scope="module")
def style():
    with plt.rc_context(plot.STYLE):
        yield


@pytest.fixture(scope="module", params=FLAT)
def flat(request, result):
    """A figure without depth, laid out as in a notebook."""
    fig = FLAT[request.param](result)
    for _ in range(2):  # as when it is saved: the layout looks at its own result
        fig.draw_without_rendering()
    yield fig
    plt.close(fig)


@pytest.fixture(scope="module")
def pixel():
    """At 100 m, above a coarser picture of the ground, which is quicker to draw."""
    lay_out = _pixel._lay_out
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            _pixel, "_lay_out", lambda *a, **k: lay_out(*a, **k | {"pixels": 16})
        )
        fig = plot.pixel_on_ground(datasets.yellowstone(), height=100.0)
    yield fig
    plt.close(fig)


@pytest.fixture(scope="module", params=["pixel_on_ground", *IN_SPACE])
def in_space(request, result):
    if request.param not in IN_SPACE:
        yield request.getfixturevalue("pixel")
        return
    fig = IN_SPACE[request.param](result)
    yield fig
    plt.close(fig)


@pytest.fixture
def axes():
    fig, ax = plt.subplots()
    yield ax
    plt.close(fig)


@pytest.fixture
def space():
    fig = plt.figure()
    yield plot.space.space(fig)
    plt.close(fig)


def drawn(ax):
    """Points (n, 2), in data units, of all that is drawn by its coordinates."""
    found = [np.empty((0, 2))]
    for line in ax.lines:
        if line.get_transform() == ax.transData:
            found.append(line.get_xydata())
    for patch in ax.patches:
        if patch.get_data_transform() == ax.transData:
            path = patch.get_path().transformed(patch.get_patch_transform())
            found.append(path.vertices)
    for many in ax.collections:
        if isinstance(many, Quiver):
            vectors = np.column_stack([many.U, many.V]) / many.scale
            found += [many.XY, many.XY + vectors]
        else:
            found += [path.vertices for path in many.get_paths()]
    points = np.concatenate(found)
    return points[np.isfinite(points).all(axis=1)]


def drawn_in_space(ax):
    """Points (n, 3) of all lines and faces."""
    found = [np.transpose(line.get_data_3d()) for line in ax.lines]
    for many in ax.collections:
        if isinstance(many, Line3DCollection):
            found += [np.array(segment) for segment in many._segments3d]
        else:
            found.append(vertices(many))
    return np.concatenate(found)


def vertices(faces):
    """Corners (n, 3) of polygons, under the names of older and newer Matplotlib."""
    if hasattr(faces, "_faces"):
        return np.ma.getdata(faces._faces).reshape(-1, 3)
    return faces._vec[:3].T


def on_paper(ax, points):
    """Where points (n, 3) of axes in space are drawn, as fractions of the figure."""
    ax.apply_aspect()
    x, y, _ = proj3d.proj_transform(*points.T, ax.get_proj())
    seen = ax.transData.transform(np.column_stack([x, y]))
    return ax.figure.transFigure.inverted().transform(seen)


def words(fig):
    """All texts but the numbers along the axes, which matplotlib chooses."""
    found = list(fig.texts)
    for ax in fig.findobj(Axes):
        found += [*ax.texts, ax.title, ax._left_title, ax.xaxis.label, ax.yaxis.label]
        if ax.get_legend():
            found += ax.get_legend().get_texts()
    return [text for text in found if text.get_text() and text.get_visible()]


def keys(fig):
    """What stands at the arrows that tell the scale."""
    return [key.text.get_text() for key in fig.findobj(QuiverKey)]


def test_all_that_is_drawn_is_inside_the_limits_of_its_axes(flat):
    for ax in flat.axes:
        points = drawn(ax)
        x, y = np.sort(ax.get_xlim()), np.sort(ax.get_ylim())
        rounding = 1e-9 * np.abs([x, y]).max(axis=1)
        low, high = np.transpose([x, y])
        assert np.all(points >= low - rounding) and np.all(points <= high + rounding)
    assert sum(len(drawn(ax)) + len(ax.images) for ax in flat.axes) > 0


def test_all_words_are_inside_the_figure(flat):
    width, height = flat.bbox.size
    for text in words(flat):
        box = text.get_window_extent()
        assert box.x0 > -1 and box.y0 > -1, text.get_text()
        assert box.x1 < width + 1 and box.y1 < height + 1, text.get_text()


def test_no_panel_covers_another(flat):
    shown = [ax for ax in flat.findobj(Axes) if ax.has_data()]
    assert shown
    for one, other in combinations(shown, 2):
        a, b = one.get_window_extent(), other.get_window_extent()
        across = min(a.x1, b.x1) - max(a.x0, b.x0)
        along = min(a.y1, b.y1) - max(a.y0, b.y0)
        assert min(across, along) < 1  # pixel


def test_all_that_stands_in_space_is_seen_inside_the_figure(in_space):
    for ax in in_space.axes:
        assert isinstance(ax, Axes3D)
        places = [text.get_position_3d() for text in ax.texts]
        points = np.concatenate([drawn_in_space(ax), np.reshape(places, (-1, 3))])
        seen = on_paper(ax, points)
        assert len(seen) and np.all((seen > 0) & (seen < 1))


def test_means_of_residuals_cannot_be_taken_for_residuals(result):
    """Means are smaller by far: the figure itself says which, and how long 1 µm is."""
    fig, _ = _figures.mean_residuals(result)
    single = plot.bundle.residual_vectors(result)
    for shown, head in ((fig, "Mean residuals"), (single, "Residuals")):
        told = [text.get_text() for text in words(shown)]
        assert [one for one in told if "esiduals" in one and one.startswith(head)]
        assert any(re.fullmatch(r"[\d.]+ µm", one) for one in told + keys(shown))
        plt.close(shown)


HANDED_BACK = {
    "error_ellipse": lambda ax: plot.error_ellipse(ax, (1, 2), np.eye(2)),
    "outline": lambda ax: common_figures.outline(ax, (5, 2), 3),
    "draw_map": lambda ax: common_figures.draw_map(ax, np.eye(3)),
}


@pytest.mark.parametrize("name", HANDED_BACK)
def test_what_is_handed_back_is_drawn(axes, name):
    assert HANDED_BACK[name](axes) in axes.get_children()


@pytest.mark.parametrize("magnify", [1.0, 50.0])
def test_an_ellipse_reaches_as_far_as_the_variances_allow(axes, magnify):
    """In x to the root of chi-square times the variance of x, and so in y."""
    C = np.array([[4.0, 1.5], [1.5, 1.0]])
    plot.error_ellipse(axes, (2, -1), C, probability=0.9, magnify=magnify)
    (ellipse,) = axes.patches
    path = ellipse.get_path().transformed(ellipse.get_patch_transform())
    box = path.get_extents()
    half = magnify * np.sqrt(chi2.ppf(0.9, 2) * np.diag(C))
    # Four Bézier curves are a circle up to 3e-4 of its radius
    np.testing.assert_allclose(box.size / 2, half, rtol=3e-4)
    np.testing.assert_allclose((box.min + box.max) / 2, (2, -1), atol=1e-9 * magnify)


def test_the_ground_is_as_wide_as_its_pixels_in_metres(pixel):
    (ax,), ortho = pixel.axes, datasets.yellowstone()
    below, above = (vertices(surface) for surface in ax.collections[:2])
    width = ortho.grey.shape[0] * ortho.gsd
    np.testing.assert_allclose(np.ptp(below, axis=0), (width, width, 0), rtol=1e-9)
    np.testing.assert_allclose(below.mean(axis=0), 0, atol=1e-9 * width)
    assert len(np.unique(above[:, 2])) == 1 and 0 < above[0, 2] < 100
    # by similar triangles from the perspective centre
    assert np.ptp(above[:, 0]) / width == pytest.approx(1 - above[0, 2] / 100)


def test_the_pixel_its_ground_and_the_perspective_centre_are_on_one_ray(pixel):
    (ax,) = pixel.axes
    image, below = (vertices(polygon)[:4] for polygon in ax.collections[2:4])
    np.testing.assert_allclose(below[:, 2], 0, atol=1e-9)
    centre = np.array([0.0, 0.0, 100.0])
    scale = (image - centre)[:, 2] / (below - centre)[:, 2]
    np.testing.assert_allclose(
        image - centre, scale[:, None] * (below - centre), atol=1e-9
    )


def test_heights_are_measured_at_the_left_square_to_the_view(pixel):
    """Bars of H and c, at the same depth as the camera: their lengths compare."""
    (ax,) = pixel.axes
    bars = [np.transpose(line.get_data_3d()) for line in ax.lines]
    bars = [bar for bar in bars if len(bar) == 2 and np.ptp(bar[:, :2]) > 0]
    upright = [bar for bar in bars if not np.ptp(bar[:, :2], axis=0).any()]
    assert len(upright) == 2
    azimuth = np.radians(ax.azim)
    for bar in upright:
        assert bar[1, 2] == 100
        towards_eye = bar[0, :2] @ (np.cos(azimuth), np.sin(azimuth))
        assert towards_eye == pytest.approx(0, abs=1e-9)
        assert on_paper(ax, bar)[0, 0] < on_paper(ax, np.zeros((1, 3)))[0, 0]


def test_half_the_band_of_a_lens_is_counted_from_zero(result, closed):
    above, below = plot.bundle.lens_curve(result).axes
    assert below.get_ylim()[0] == 0
    assert above.get_ylim()[0] < above.lines[0].get_ydata().min()


def test_landscapes_of_two_correlations_have_one_scale_with_the_map_as_its_floor():
    limits = []
    for highest in (0.2, 1.0):
        ax = plt.figure().add_subplot(projection="3d")
        common_figures.draw_surface(ax, highest * np.eye(5), lowest=-0.6)
        limits.append(ax.get_zlim())
        plt.close(ax.figure)
    assert limits[0] == limits[1]
    assert limits[0][0] == pytest.approx(-0.6) and limits[0][1] > 1


def test_blocks_without_rows_have_no_name(closed):
    def names(**size):
        (ax,) = ch06_case_figures.normal_matrix(PHOTO, POINT, **size).axes
        found = [text.get_text() for text in ax.texts]
        return [one for one in found if one and "filled" not in one]

    apart = "eliminate\nthe points"
    left = ["9 × 6 photos", "50 × 3 points"]
    assert names(interior=0, border=0) == [*left, "9 × 6 photos", apart]
    assert "interior 3" in names(interior=3, border=0)
    assert "G 7" in names(interior=0, border=7)


def test_a_bar_beside_the_matrix_spans_the_rows_of_each_group(closed):
    (ax,) = ch06_case_figures.normal_matrix(PHOTO, POINT).axes
    groups = np.array([10, 54, 150, 7])
    spans = np.array([line.get_ydata() for line in ax.lines])
    for sizes, found in ((groups, spans[:4]), (groups[[0, 1, 3]], spans[4:])):
        end = np.cumsum(sizes)
        np.testing.assert_allclose(found, np.transpose([end - sizes, end]), atol=1)
        assert np.all(found[1:, 0] > found[:-1, 1])  # with gaps between them


def test_a_block_of_a_matrix_is_drawn_as_high_as_wide(closed):
    (ax,) = ch06_case_figures.normal_matrix(PHOTO, POINT).axes
    ax.apply_aspect()
    (x0, y0), (x1, y1) = ax.transData.transform([(0, 0), (6, 6)])
    assert abs(x1 - x0) == pytest.approx(abs(y1 - y0))


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (np.full((50, 3, 3), np.nan), "covariance_points.* not a finite number"),
        (np.ones((50, 3)), r"covariance_points must have shape \(50, 3, 3\)"),
        (-np.tile(np.eye(3), (50, 1, 1)), "covariance_points.* no positive variance"),
        (np.tile(np.triu(np.ones((3, 3))), (50, 1, 1)), "points.* is not symmetric"),
        ("none", "covariance_points"),
    ],
)
def test_what_is_no_covariance_is_refused_by_its_name(result, wrong, message):
    with pytest.raises(ValueError, match=message):
        ch06_figures.network_3d(result.exteriors, result.points, wrong)


def test_a_list_of_covariances_is_as_good_as_an_array(result, closed):
    C = result.covariance_points
    fig = ch06_figures.network_3d(result.exteriors, result.points, C.tolist())
    assert "standard ellipsoids" in fig.get_suptitle()


def test_a_camera_is_its_image_plane_and_four_rays_from_the_centre(space):
    form = (1.2, 0.8)
    plot.space.draw_camera(space, EXTERIOR, 2.5, form=form, axes=False)
    corners = plot.space.frustum(EXTERIOR, 2.5, form)
    rays, plane = space.collections
    assert isinstance(plane, Poly3DCollection)
    np.testing.assert_allclose(vertices(plane)[:4], corners)
    segments = np.array(rays._segments3d)
    np.testing.assert_allclose(segments[:, 0], np.tile(EXTERIOR[:3], (4, 1)))
    np.testing.assert_allclose(segments[:, 1], corners)


@pytest.mark.parametrize("c", [1.0, 35.0])
def test_a_photo_is_as_wide_and_high_as_its_form_says(axes, c):
    """The corners of the camera drawn in space are the corners of its photo."""
    form = (1.2, 0.7)
    corners = plot.space.frustum(EXTERIOR, 2.5, form)
    plot.space.draw_photo(axes, EXTERIOR, [(corners, "red")], c, form)
    (path,) = axes.collections[0].get_paths()
    seen = path.vertices[:4]
    limits = np.array([axes.get_xlim(), axes.get_ylim()])
    np.testing.assert_allclose(limits[:, 1] - limits[:, 0], c * np.array(form))
    np.testing.assert_allclose([seen.min(axis=0), seen.max(axis=0)], limits.T)


@pytest.mark.parametrize("ground", [None, "green"])
def test_above_the_horizon_is_sky(axes, ground):
    """A camera that looks to the horizon: it halves the photo."""
    level = [0, 0, 5, np.pi / 2, 0, 0]
    assert rotation.matrix(*level[3:])[1] @ (0, 0, 1) == pytest.approx(1)
    axes.set_position((0, 0, 1, 1))
    plot.space.draw_photo(axes, level, [], ground=ground)
    axes.figure.canvas.draw()
    box = axes.get_window_extent()
    pixels = np.asarray(axes.figure.canvas.buffer_rgba())[..., :3] / 255
    across = int(box.x0 + 0.2 * box.width)
    above, below = (
        pixels[int(axes.figure.bbox.height - box.y0 - part * box.height), across]
        for part in (0.8, 0.2)
    )
    sky = to_rgb(plot.space.SKY_COLOR)
    assert above[2] > above[0] + 0.05  # blue, not the white of paper
    np.testing.assert_allclose(above, sky, atol=1 / 255)
    np.testing.assert_allclose(below, to_rgb(ground or sky), atol=1 / 255)


def test_time_stands_left_and_memory_right_of_each_other(closed):
    time, memory = ch06_case_figures.size_study(
        [450, 8e4], SECONDS, [3, 140], ["a", "b"]
    ).axes
    one, other = time.get_position(), memory.get_position()
    assert one.x1 < other.x0
    assert (one.y0, one.y1) == pytest.approx((other.y0, other.y1))
