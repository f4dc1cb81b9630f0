"""Files read back by the libraries of their formats."""

import contextlib
import sys
from dataclasses import replace

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


def table(file):
    return np.genfromtxt(file, delimiter=",", names=True)


def test_points_as_csv(points, tmp_path):
    read = table(stereo.save_points(points, tmp_path / "new" / "points.csv"))
    assert np.allclose(read["Y"], points.xyz[:, 1], atol=1e-4, rtol=0)
    assert np.allclose(read["sd_Z"], points.sd[:, 2])
    assert np.array_equal(read["column"], points.cells[:, 0])


def test_points_as_las_also_when_they_are_far_apart(points, tmp_path):
    laspy = pytest.importorskip("laspy")
    read = laspy.read(stereo.save_points(points, tmp_path / "points.las"))
    assert np.allclose(read.xyz, points.xyz, atol=0.51e-4, rtol=0)
    for name, values in (("sd_X", points.sd[:, 0]), ("r", points.r)):
        assert np.allclose(read[name], values)
    points.xyz[0] = 0
    read = laspy.read(stereo.save_points(points, tmp_path / "far.las"))
    assert np.allclose(read.xyz, points.xyz, atol=0.02, rtol=0)


@pytest.mark.parametrize("suffix", ["las", "tif"])
def test_the_reference_system_is_written_as_asked_or_as_known(suffix, points, tmp_path):
    pytest.importorskip("rasterio")
    for known, asked, expected in (
        ("EPSG:32748", None, 32748), ("EPSG:32748", "EPSG:32633", 32633),
        (None, "EPSG:32633", 32633), (None, None, None),
    ):  # fmt: skip
        cloud = replace(points, crs=known)
        file = tmp_path / f"{known}_{asked}.{suffix}".replace(":", "_")
        save = stereo.save_points
        if suffix == "tif":
            cloud, save = stereo.surface(cloud, 100.0), stereo.save_surface
        with contextlib.ExitStack() as stack:
            if known and asked:
                said = "crs='EPSG:32633' is written, but the photos name 'EPSG:32748'"
                stack.enter_context(pytest.warns(UserWarning, match=said))
            save(cloud, file, crs=asked)
        assert read_crs(file) == expected
        degrees = "EPSG:4326"
        with pytest.raises(ValueError, match=f"'{degrees}' counts in degrees"):
            cloud = replace(cloud, crs=known or degrees)
            save(cloud, file.with_stem("degrees"), crs=known and degrees)
        assert not file.with_stem("degrees").exists()
    if suffix == "las":
        with pytest.raises(ValueError, match="'nowhere' is not known"):
            stereo.save_points(points, tmp_path / "a.las", crs="nowhere")
        with pytest.raises(ValueError, match=r"cannot store it; save as \.las"):
            stereo.save_points(points, tmp_path / "a.csv", crs="EPSG:32748")


def test_the_terrain_keeps_the_system_of_its_surface(tmp_path):
    pytest.importorskip("rasterio")
    flat, measured = np.ones((9, 9)), np.ones((9, 9), bool)
    dsm = stereo.Surface(flat, (0.0, 0.0), 1.0, measured, crs="EPSG:32748")
    dtm = stereo.filter_terrain(dsm)
    assert read_crs(stereo.save_surface(dtm, tmp_path / "dtm.tif")) == 32748


def read_crs(file):
    """Number of EPSG, by rasterio or by laspy and pyproj; None if there is none."""
    if file.suffix == ".tif":
        import rasterio

        with rasterio.open(file) as read:
            return read.crs and read.crs.to_epsg()
    laspy, _ = (pytest.importorskip(name) for name in ("laspy", "pyproj"))
    header = laspy.read(file).header
    crs = header.parse_crs()
    assert header.global_encoding.wkt == (crs is not None)
    return crs and crs.to_epsg()


def test_compressed_points_or_what_to_install(points, tmp_path):
    laspy = pytest.importorskip("laspy")
    if laspy.LazBackend.detect_available():
        read = laspy.read(stereo.save_points(points, tmp_path / "points.laz"))
        assert np.allclose(read.xyz, points.xyz, atol=0.51e-4, rtol=0)
    else:
        with pytest.raises(ImportError, match="pip install lazrs"):
            stereo.save_points(points, tmp_path / "points.laz")
        assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "layer"), [("surface", "source"), ("terrain", "origin")]
)
def test_heights_as_geotiff_and_as_csv(name, layer, tmp_path, request):
    rasterio = pytest.importorskip("rasterio")
    what = request.getfixturevalue(name)
    values, (x, y) = getattr(what, layer), what.corner
    with rasterio.open(
        stereo.save_surface(what, tmp_path / "dsm.tif", crs="EPSG:32748")
    ) as read:
        assert np.array_equal(read.read(1), what.z.astype(np.float32), equal_nan=True)
        assert np.array_equal(read.read(2), values)
        assert np.isnan(read.nodata) and read.crs.to_epsg() == 32748
        # rasterio gives the middle of a cell
        assert read.xy(0, 0) == (x, y) and read.xy(1, 2) == (x + 1.0, y - 0.5)
        assert read.descriptions == ("height", layer)
        assert read.tags(2)["meaning"].startswith(("0 measured, 1 ", "0 ground, 1 "))
    read = table(stereo.save_surface(what, tmp_path / "dsm.csv"))
    known = np.isfinite(what.z)
    assert (read["X"][0], read["Y"][0]) == (x + 1.5, y)
    assert np.allclose(read["Z"], what.z[known])
    assert np.array_equal(read[layer], values[known])


def test_what_cannot_be_saved_is_refused(points, surface, tmp_path, monkeypatch):
    for library in ("laspy", "rasterio"):
        monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(ImportError, match="pip install laspy"):
        stereo.save_points(points, tmp_path / "a.las")
    with pytest.raises(ImportError, match="pip install rasterio"):
        stereo.save_surface(surface, tmp_path / "a.tif")
    with pytest.raises(ValueError, match=r"\.csv or \.las or \.laz"):
        stereo.save_points(points, tmp_path / "points.txt")
    with pytest.raises(ValueError, match="cannot store it"):
        stereo.save_surface(surface, tmp_path / "dsm.csv", crs="EPSG:32748")
    none = stereo.Points(*np.empty((2, 0, 3)), np.empty(0), np.empty((0, 2)))
    with pytest.raises(ValueError, match="no points"):
        stereo.save_points(none, tmp_path / "points.csv")
    for value in (np.nan, np.inf, -1e31):
        odd = stereo.Points(points.xyz.copy(), points.sd, points.r, points.cells)
        odd.xyz[1, 2] = value
        with pytest.raises(ValueError, match=r"points\.xyz\[1\] are NaN, infinite"):
            stereo.save_points(odd, tmp_path / "points.csv")
