"""The terrain below houses and trees: against the truth, and against a grey opening."""

import cv2
import numpy as np
import pytest
from scipy.interpolate import RBFInterpolator

from pgm_lab import simulate, stereo
from pgm_lab.simulate.landscape import BUILDING, OPEN, TREE
from pgm_lab.stereo import terrain as module
from pgm_lab.stereo.terrain import BETWEEN, GROUND, NOTHING, UNDER

CELL = 0.5


@pytest.fixture(scope="module")
def land():
    """Open fields, houses and a wood on the hills of 40 m relief."""
    return simulate.landscape((-100, -60, 100, 60), cell=CELL)


def of(z, measured=None):
    measured = np.isfinite(z) if measured is None else measured
    return stereo.Surface(z.astype(float), (0.0, 0.0), CELL, measured)


@pytest.fixture(scope="module")
def terrain(land):
    return stereo.filter_terrain(of(land.dsm))


def opening(z, widest=40.0):
    side = int(widest / CELL) + 1
    return cv2.morphologyEx(z, cv2.MORPH_OPEN, np.ones((side, side), np.uint8))


@pytest.mark.parametrize("kind", [BUILDING, TREE])
def test_ground_under_objects_is_found_to_two_decimetres(land, terrain, kind):
    found = stereo.quality(terrain.z, land.dtm, land.kind == kind)
    plain = stereo.quality(opening(land.dsm), land.dtm, land.kind == kind)
    assert found.completeness == 1 and found.n > 1000
    assert found.rmse < 0.20
    assert plain.rmse > 2.5 * found.rmse


def test_open_ground_keeps_its_heights_and_objects_do_not(land, terrain):
    ground = terrain.origin == GROUND
    assert np.array_equal(terrain.z[ground], land.dsm[ground])
    assert ground[land.kind == OPEN].mean() > 0.7
    tall = land.dsm - land.dtm > 1
    assert (terrain.origin[tall] == UNDER).all()


def test_a_bare_hill_is_left_as_it_is(land):
    bare = stereo.filter_terrain(of(land.dtm))
    assert (bare.origin == GROUND).mean() > 0.999
    assert np.abs(bare.z - land.dtm).max() < 0.05
    # where an opening alone cuts off the top
    assert np.abs(opening(land.dtm) - land.dtm).max() > 2


def test_cells_that_were_interpolated_say_nothing_about_the_ground(land):
    # A ramp between two roofs, where nothing was measured
    z = np.full((80, 80), 10.0)
    z[30:50, 20:34], z[30:50, 46:60] = 16.0, 16.0
    z[30:50, 34:46] = 12.0
    measured = np.ones(z.shape, bool)
    measured[30:50, 34:46] = False
    terrain = stereo.filter_terrain(of(z, measured))
    assert np.abs(terrain.z - 10).max() < 0.05
    assert (terrain.origin[30:50, 36:44] == BETWEEN).all()


def test_no_height_is_invented_where_the_surface_has_none(land):
    z = land.dsm.copy()
    z[:, :30] = np.nan
    terrain = stereo.filter_terrain(of(z))
    assert np.array_equal(np.isnan(terrain.z), np.isnan(z))
    assert np.array_equal(terrain.origin == NOTHING, np.isnan(z))


SLOW = pytest.mark.slow


@pytest.mark.parametrize(
    "slope", [0.1, *(pytest.param(s, marks=SLOW) for s in (0, 0.3, 0.5))]
)
@pytest.mark.parametrize(
    "cell", [*(pytest.param(c, marks=SLOW) for c in (0.5, 1.0)), 2.0]
)
def test_whatever_is_no_wider_than_widest_goes_whole(cell, slope):
    """Halls with roofs parallel to the ground, and pits."""
    n, sizes = round(120 / cell), np.array([6, 14, 24, 30, 38])
    ground = np.tile(slope * cell * np.arange(n), (n, 1))
    cases = [(s, h) for s in sizes for h in (2.0, 4.0, 10.0)] + [(6, -4.0), (14, -4.0)]
    for size, height in cases:
        first = n // 2 - round(size / cell / 2)
        object_ = slice(first, first + round(size / cell))
        z = ground.copy()
        z[object_, object_] += height
        dsm = stereo.Surface(z, (0.0, 0.0), cell, np.ones(z.shape, bool))
        found = stereo.filter_terrain(dsm)
        assert np.abs(found.z - ground).max() < 0.03, (size, height)
        assert (found.origin[object_, object_] == UNDER).all()


def test_what_is_an_object_follows_from_noise_and_cell():
    """Mountains in cells of 12 m, with heights good to 0.6 m: 98 % are ground."""
    y, x = 12.0 * np.mgrid[:80, :80]
    hills = 150 * np.sin(x / 150) * np.cos(y / 200)
    z = hills + 0.6 * np.random.default_rng(1).normal(size=x.shape)
    dsm = stereo.Surface(z, (0.0, 0.0), 12.0, np.isfinite(z))
    found = stereo.filter_terrain(dsm)
    assert (found.origin == GROUND).mean() > 0.98
    assert np.std(found.z - hills) < 0.65
    flat = z - hills
    assert module._noise(flat, np.isfinite(z), 1) == pytest.approx(0.6, rel=0.03)
    assert module._noise(z, np.zeros(z.shape, bool), 1) == 0


def test_ground_stays_in_the_cells_of_a_drone():
    """Hilly ground good to a centimetre, with a shed on it."""
    cell = 0.05
    y, x = cell * np.mgrid[:400, :400]
    hills = 2 * np.sin(x / 10) * np.cos(y / 12)
    z = hills + 0.01 * np.random.default_rng(1).normal(size=x.shape)
    shed = slice(150, 150 + round(3 / cell))
    z[shed, shed] += 2.5
    found = stereo.filter_terrain(stereo.Surface(z, (0, 0), cell, np.isfinite(z)))
    assert (found.origin[shed, shed] == UNDER).all()
    assert (found.origin == GROUND).mean() > 0.9
    assert np.abs(found.z - hills).max() < 0.1


def test_house_on_a_slope_is_removed_and_the_slope_stays():
    X = CELL * np.arange(120)
    for slope in (0.0, 0.15, 0.3):
        ground = np.tile(slope * X, (100, 1))
        z = ground.copy()
        z[40:68, 50:78] = ground[40:68, 50:78].max() + 5
        terrain = stereo.filter_terrain(of(z))
        assert np.abs(terrain.z - ground).max() < 0.02
        assert (terrain.origin[40:68, 50:78] == UNDER).all()


def hills(slope, sharp=False, cell=CELL):
    """A house of 14 m on hills of 80 m, or on ridges, with heights good to 5 cm."""
    y, x = cell * np.mgrid[: round(120 / cell), : round(150 / cell)]
    k = 2 * np.pi / 80
    ground = slope / k * np.sin(k * x) * np.cos(0.8 * k * y)
    if sharp:
        ground = slope * np.abs(x % 66 - 33)
    z = ground + np.random.default_rng(1).normal(0, 0.05, x.shape)
    house = (y >= 50) & (y < 64) & (x >= 45) & (x < 59)
    z[house] += 6.0
    return ground, stereo.Surface(z, (0.0, 0.0), cell, np.isfinite(z)), house


@pytest.mark.parametrize("cell", [CELL, 0.2])
@pytest.mark.parametrize("slope", [0.45, 0.9])
def test_steep_hills_stay_and_the_house_on_them_goes(slope, cell):
    ground, dsm, house = hills(slope, cell=cell)
    found = stereo.filter_terrain(dsm)
    assert stereo.quality(found.z, ground).rmse < 0.06
    assert (found.origin[house] == UNDER).all()


def test_plates_that_eat_sharp_crests_are_said_to():
    ground, dsm, _ = hills(0.9, sharp=True)
    with pytest.warns(
        UserWarning, match=r"changed \d\.\d%: .* least too small for sharp crests"
    ):
        stereo.filter_terrain(dsm)
    right = stereo.filter_terrain(dsm, least=2, slope=0.9)  # silent
    assert stereo.quality(right.z, ground).rmse < 0.1


def test_the_plate_is_the_thin_plate_spline_of_its_ground():
    """Beneath a house on a hill that bends and twists, against SciPy's spline."""
    rows, columns = np.mgrid[:60, :60].astype(float)
    x, y = (columns - 30) / 30, (rows - 30) / 30
    hill = 4 * x * y + 2 * np.exp(-2 * (x**2 + y**2))
    known = np.ones(hill.shape, bool)
    known[18:36, 22:44] = False
    ground = np.stack([rows[known], columns[known]], -1)
    spline = RBFInterpolator(ground, hill[known], neighbors=300)
    under = spline(np.stack([rows[~known], columns[~known]], -1))
    plate = module._plate(hill, known, 1)
    assert np.abs(plate[~known] - under).max() < 0.05  # m, on a hill of 10 m
    assert np.abs(plate - hill)[known].max() < 0.02


def test_the_bending_energy_is_that_of_a_thin_plate():
    """The sum of zxx^2 + 2 zxy^2 + zyy^2, known in closed form for these surfaces."""
    n = 20
    y, x = np.mgrid[:n, :n].astype(float)
    bending = module._bending((n, n))
    energies = [np.ravel(z) @ (bending @ np.ravel(z)) for z in (x, x * y, x**2, y**2)]
    np.testing.assert_allclose(
        energies, [0, 2 * (n - 1) ** 2, 4 * n * (n - 2), 4 * n * (n - 2)], atol=1e-9
    )


def test_a_terrain_that_rests_on_nothing_measured_is_said_to(land):
    """A smooth valley amid hills whose heights are good to 2.3 m, in cells of 24 m.

    With a `least` for decimetres all hills are objects, wider than any.
    """
    y, x = 24.0 * np.mgrid[:60, :60]
    rise = np.clip(x - 350, 0, None)
    hills = 150 * (1 - np.cos(rise / 300))
    noise = 2.3 * np.random.default_rng(1).normal(size=x.shape)
    z = hills + np.where(rise > 0, noise, 0)
    dsm = stereo.Surface(z, (0.0, 0.0), 24.0, np.isfinite(z))
    with pytest.warns(UserWarning, match=r"cells are ground, and 7\d\.\d% lie farther"):
        wrong = stereo.filter_terrain(dsm, least=0.5, most=3.0)
    assert stereo.quality(wrong.z, hills).rmse > 100
    right = stereo.filter_terrain(dsm)  # silent, as a warning is an error
    assert stereo.quality(right.z, hills).rmse < 2.3
    # Or where little of a smooth scene is ground, though none of it is far away
    rough = cv2.GaussianBlur(
        np.random.default_rng(3).normal(size=land.dsm.shape), (0, 0), 2
    )
    with pytest.warns(UserWarning, match=r"^\d\.\d% of the measured cells are ground"):
        stereo.filter_terrain(of(land.dsm + rough / rough.std()))


def test_surface_without_ground_is_refused():
    rough = np.random.default_rng(1).uniform(0, 50, (40, 40))
    with pytest.raises(ValueError, match="too little of the surface is ground"):
        stereo.filter_terrain(of(rough), most=0.5)
    # All of it in one cell of the plate, which is free to turn
    one = np.zeros(rough.shape, bool)
    one[:4, :4] = True
    with pytest.raises(ValueError, match="too little of the surface is ground"):
        module._plate(rough, one, 8)
    with pytest.raises(ValueError, match="no heights at all"):
        stereo.filter_terrain(of(np.full((40, 40), np.nan)))
