"""What was measured goes on into a bundle, through a file and without one."""

from dataclasses import replace

import numpy as np
import pytest

from pgm_lab import bundle, camera, observations, stereo_map
from tests.stereo_map.conftest import true_ground


@pytest.fixture(scope="module")
def ground(bare, unknown):
    control = {p.name: true_ground(bare, p) for p in unknown.points[::3]}
    return stereo_map.orient(unknown, control)


def test_the_table_is_read_by_the_bundle_to_the_last_bit(ground, tmp_path):
    path = tmp_path / "my_points.csv"
    stereo_map.save(ground, path)
    files = stereo_map.save_network(ground, tmp_path / "network")
    network = bundle.read(*files[:3], path)
    n = len(ground.points)
    assert network.photo_names == (1, 2) and len(network.xy) == 2 * n
    for k in (0, 1):
        of_photo = network.photo == k
        names = [network.point_names[i] for i in network.point[of_photo]]
        assert names == [p.name for p in ground.points]
        assert np.array_equal(network.xy[of_photo], [p.photo[k] for p in ground.points])
        expected = [p.photo_sd[k] for p in ground.points]
        np.testing.assert_allclose(network.sigma[of_photo], expected, rtol=1e-12)


def test_the_bundle_of_the_two_photos_agrees(ground, bare):
    found = bundle.adjust(stereo_map.network(ground), ())
    assert found.status == "converged" and found.redundancy == len(ground.points) - 5
    assert found.sigma0 < 1.5
    truth = np.array([true_ground(bare, p) for p in ground.points])
    errors = found.network.points - truth
    assert np.sqrt(np.mean(errors**2, axis=0)).max() < 0.5  # m; a pixel is 0.69 m


def test_what_cannot_be_saved_leaves_everything_as_it_was(
    ground, oriented, unknown, tmp_path
):
    with pytest.raises(ValueError, match="no point was kept yet"):
        stereo_map.save(oriented, tmp_path / "none.csv")
    with pytest.raises(ValueError, match="not oriented yet"):
        stereo_map.network(unknown)
    assert not list(tmp_path.iterdir())
    stereo_map.save(ground, tmp_path / "my_points.csv")
    with pytest.raises(FileExistsError):
        stereo_map.save(ground, tmp_path / "my_points.csv")
    stereo_map.save(stereo_map.undo(ground), tmp_path / "my_points.csv", overwrite=True)


def test_two_cameras_make_a_network_and_no_four_files(ground, tmp_path):
    other = replace(ground.right.camera, c=ground.right.camera.c + 0.01)
    two = replace(ground, right=replace(ground.right, camera=other))
    assert len(stereo_map.network(two).cameras) == 2
    with pytest.raises(ValueError, match="several cameras"):
        stereo_map.save_network(two, tmp_path)


def test_the_saved_file_is_taken_by_the_network_as_its_rows_are(ground, tmp_path):
    path = tmp_path / "my_points.csv"
    stereo_map.save(ground, path)
    whole = stereo_map.network(ground)
    photos = dict(zip(whole.photo_names, whole.exteriors))
    points = dict(zip(whole.point_names, whole.points))
    for observed in (path, str(path), observations.read(path).rows):
        network = bundle.Network.of(whole.cameras[0], photos, points, observed)
        for name in ("photo", "point", "xy"):
            assert np.array_equal(getattr(network, name), getattr(whole, name))
        np.testing.assert_allclose(network.sigma, whole.sigma, rtol=1e-12)
    as_texts = ({str(name): row for name, row in t.items()} for t in (photos, points))
    network = bundle.Network.of(whole.cameras[0], *as_texts, path)
    assert network.photo_names == ("1", "2")
    assert np.array_equal(network.xy, whole.xy)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("8,1,0.5,0.5,0.001,0.001", "points.csv, line 2: point 8 is not in points"),
        ("7,3,0.5,0.5,0.001,0.001", "points.csv, line 2: photo 3 is not in photos"),
    ],
)
def test_a_wrong_line_of_a_file_is_named(tmp_path, line, message):
    path = tmp_path / "points.csv"
    path.write_text(f"% a comment\n{line}\n", encoding="utf-8")
    photos = {1: np.zeros(6), 2: np.ones(6)}
    with pytest.raises(ValueError, match=message):
        bundle.Network.of(camera.Camera(35.0), photos, {7: (0, 0, -9)}, path)
    with pytest.raises(FileNotFoundError):
        bundle.Network.of(camera.Camera(35.0), photos, {7: (0, 0, -9)}, "none.csv")


def test_observations_of_a_file_need_standard_deviations(tmp_path):
    path = tmp_path / "points.csv"
    path.write_text("7,1,0.5,0.5,0.001,0", encoding="utf-8")
    with pytest.raises(ValueError, match="line 1: sy = 0: a standard deviation must"):
        observations.read(path)
