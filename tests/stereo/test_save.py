"""Files read back by the libraries of their formats."""

import sys

import numpy as np
import pytest

from pgm_lab import stereo


@pytest.fixture
def points():
    rng = np.random.default_rng(1)
    xyz = rng.uniform((4.3e5, 9.1e6, 100), (4.31e5, 9.101e6, 180), (50, 3))
    sd = rng.uniform(0.1, 0.3, (50, 3))
    cells = rng.integers(0, 900, (50, 2))
    return stereo.Points(xyz, sd, rng.uniform(0.8, 1, 50), cells)


@pytest.fixture
def surface():
    z = np.random.default_rng(2).uniform(0, 40, (6, 9))
    z[:2, :3] = np.nan
    return stereo.Surface(z, (431000.25, 9100999.75), 0.5, np.isfinite(z))


@pytest.fixture
def terrain(surface):
    origin = np.where(np.isnan(surface.z), 3, 1).astype(np.uint8)
    return stereo.Terrain(surface.z, origin, surface.corner, surface.cell)


def test_points_as_csv(points, tmp_path):
    file = stereo.save_points(points, tmp_path / "new" / "points.csv")
    read = np.genfromtxt(file, delimiter=",", names=True)
    assert np.allclose(read["Y"], points.xyz[:, 1], atol=1e-4, rtol=0)
    assert np.allclose(read["sd_Z"], points.sd[:, 2])
    assert np.array_equal(read["column"], points.cells[:, 0])


def test_points_as_las(points, tmp_path):
    laspy = pytest.importorskip("laspy")
    read = laspy.read(stereo.save_points(points, tmp_path / "points.las"))
    assert np.allclose(read.xyz, points.xyz, atol=0.51e-4, rtol=0)
    for name, values in (("sd_X", points.sd[:, 0]), ("r", points.r)):
        assert np.allclose(read[name], values)


def test_compressed_points_or_what_to_install(points, tmp_path):
    laspy = pytest.importorskip("laspy")
    if laspy.LazBackend.detect_available():
        read = laspy.read(stereo.save_points(points, tmp_path / "points.laz"))
        assert np.allclose(read.xyz, points.xyz, atol=0.51e-4, rtol=0)
    else:
        with pytest.raises(ImportError, match="pip install lazrs"):
            stereo.save_points(points, tmp_path / "points.laz")
        assert not list(tmp_path.iterdir())


def test_points_far_apart_fit_into_las(points, tmp_path):
    laspy = pytest.importorskip("laspy")
    points.xyz[0] = (0, 0, 0)
    read = laspy.read(stereo.save_points(points, tmp_path / "points.las"))
    assert np.allclose(read.xyz, points.xyz, atol=0.02, rtol=0)


@pytest.mark.parametrize("name", ["surface", "terrain"])
def test_heights_as_geotiff(name, tmp_path, request):
    rasterio = pytest.importorskip("rasterio")
    what = request.getfixturevalue(name)
    file = stereo.save_surface(what, tmp_path / "dsm.tif", crs="EPSG:32748")
    layer = what.source if name == "surface" else what.origin
    with rasterio.open(file) as read:
        assert np.array_equal(read.read(1), what.z.astype(np.float32), equal_nan=True)
        assert np.array_equal(read.read(2), layer)
        assert np.isnan(read.nodata) and read.crs.to_epsg() == 32748
        # rasterio gives the middle of a cell
        assert read.xy(0, 0) == what.corner
        assert read.xy(1, 2) == (what.corner[0] + 1.0, what.corner[1] - 0.5)
        second = "source" if name == "surface" else "origin"
        assert read.descriptions == ("height", second)


def test_heights_as_csv(terrain, tmp_path):
    read = np.genfromtxt(
        stereo.save_surface(terrain, tmp_path / "dtm.csv"), delimiter=",", names=True
    )
    assert len(read) == np.isfinite(terrain.z).sum()
    assert read["X"][0] == terrain.corner[0] + 1.5
    assert read["Y"][0] == terrain.corner[1]
    assert read["Z"][0] == pytest.approx(terrain.z[0, 3])
    assert (read["origin"] == 1).all()


def test_a_file_that_is_there_stays(points, tmp_path):
    file = tmp_path / "points.csv"
    file.write_text("mine")
    with pytest.raises(FileExistsError, match="already exists"):
        stereo.save_points(points, file)
    assert file.read_text() == "mine"
    stereo.save_points(points, file, overwrite=True)
    assert file.read_text().startswith("X,Y,Z")


def test_nothing_half_written_is_left(surface, tmp_path):
    pytest.importorskip("rasterio")
    with pytest.raises(ValueError, match="is not known"):
        stereo.save_surface(surface, tmp_path / "dsm.tif", crs="nowhere")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("library", "name", "save"),
    [("laspy", "a.las", "save_points"), ("rasterio", "a.tif", "save_surface")],
)
def test_missing_library_is_named(
    library, name, save, points, surface, tmp_path, monkeypatch
):
    monkeypatch.setitem(sys.modules, library, None)
    what = points if save == "save_points" else surface
    with pytest.raises(ImportError, match=f"pip install {library}"):
        getattr(stereo, save)(what, tmp_path / name)


def test_unknown_end_is_refused_with_what_can_be_written(points, surface, tmp_path):
    with pytest.raises(ValueError, match=r"\.csv or \.las or \.laz"):
        stereo.save_points(points, tmp_path / "points.txt")
    with pytest.raises(ValueError, match=r"\.csv or \.tif"):
        stereo.save_surface(surface, tmp_path / "dsm.png")


def test_no_points_are_not_saved(tmp_path):
    none = stereo.Points(*np.empty((2, 0, 3)), np.empty(0), np.empty((0, 2)))
    with pytest.raises(ValueError, match="no points"):
        stereo.save_points(none, tmp_path / "points.csv")
