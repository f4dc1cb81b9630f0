"""pgm_lab calibrate: from files of photos to a camera in every program's file."""

import cv2
import numpy as np
import pytest
from PIL import Image

from pgm_lab import bundle, camera, stereo
from pgm_lab.command import main
from tests.calibration import rendered


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Photos and board.json; two photos lie on their side, one shows no board."""
    folder = tmp_path_factory.mktemp("my board")
    rendered.BOARD.save(folder / "board.json")
    for i, one in enumerate(rendered.scene()[1]):
        exif = Image.Exif()
        exif[274] = (1, 6, 1, 8)[i % 4]
        Image.fromarray(one.grey).save(folder / f"IMG_{i}.png", exif=exif)
    grey = np.full(rendered.SIZE[::-1], 99, np.uint8)
    Image.fromarray(grey).save(folder / "wall.png")
    return folder


@pytest.fixture
def there(folder, monkeypatch):
    monkeypatch.chdir(folder)
    return folder


def refused(capsys, *words):
    with pytest.raises(SystemExit) as end:
        main(["calibrate", *words])
    assert end.value.code == 2
    return " ".join(capsys.readouterr().err.split())


def test_all_files_are_of_one_camera_which_is_the_true_one(there, tmp_path, capsys):
    names = [tmp_path / name for name in ("c.json", "c.yml", "cameras.txt", "c.xml")]
    options = ("--camera", "--opencv", "--colmap", "--metashape")
    words = [str(w) for pair in zip(options, names) for w in pair]
    report = tmp_path / "report.html"
    words += ["--pixel-size", "0.01", "--board", "board.json", "--report", str(report)]
    assert main(["calibrate", "*.png", *words]) == 0
    output = capsys.readouterr()
    assert "wall.png: no marker is seen" in " ".join(output.out.split())
    assert output.err == ""
    assert report.read_text("utf-8").startswith("<!DOCTYPE html>")

    # The camera is true, and taken by what uses one
    file = camera.files.read(names[0])
    truth = rendered.scene()[0]
    sd = np.sqrt(np.diagonal(file.covariance))
    true = [getattr(truth, name) for name in file.estimate]
    now = [getattr(file.camera, name) for name in file.estimate]
    assert np.abs((np.array(now) - true) / sd).max() < 4
    assert not file.nominal and file.image_size == rendered.SIZE
    photo = stereo.PhotoFile("IMG_0.png", names[0], (0, 0, 9, 0, 0, 0))
    assert photo.read().camera == camera.Camera.read(names[0])

    # OpenCV's file says the same: the image of a point by its own projection
    stored = cv2.FileStorage(str(names[1]), cv2.FILE_STORAGE_READ)
    K, k = (
        stored.getNode(name).mat()
        for name in ("camera_matrix", "distortion_coefficients")
    )
    points = np.array([[0.3, -0.2, 1.0], [-0.4, 0.1, 1.0]])
    theirs = cv2.projectPoints(points, np.zeros(3), np.zeros(3), K, k)[0][:, 0]
    ours = camera.project(file.camera, np.zeros(6), points * (1, -1, -1))
    size = rendered.SIZE
    pixels = ours / 0.01 * (1, -1) + np.array(size) / 2 - 0.5
    np.testing.assert_allclose(theirs, pixels, atol=1e-9)
    assert "480 360" in names[2].read_text() and "<calibration>" in names[3].read_text()
    stored.release()


@pytest.mark.slow
def test_no_pixel_size_gives_a_nominal_one(there, tmp_path, capsys):
    out = tmp_path / "c.json"
    words = ["--board", "board.json", "--camera", str(out), "--estimate", "c,x0,y0,K1"]
    assert main(["calibrate", str(there), *words]) == 0
    assert "The size of a pixel is not known" in capsys.readouterr().out
    file = camera.files.read(out)
    assert file.nominal and file.pixel_size == 0.001
    assert file.estimate == ("c", "x0", "y0", "K1") and file.camera.K2 == 0


def test_what_is_wrong_is_said_before_the_work(there, capsys):
    board = ("--board", "board.json")
    assert "x*.png: there are no photos" in refused(capsys, "x*.png", *board)
    assert "required: --board" in refused(capsys, "*.png")
    words = refused(capsys, "*.png", *board, "--camera", "board.json")
    assert "it exists already" in words
    words = refused(capsys, "*.png", *board, "--opencv", "c.json")
    assert "must end in .yml" in words
    assert "'K9' is not one of" in refused(capsys, "*.png", *board, "--estimate", "K9")
    words = ["calibrate", "wall.png", "IMG_0.png", *board]
    assert main(words) == 1
    assert "1 of 2 photos show the board well enough" in capsys.readouterr().err
    assert main(["calibrate", "IMG_0.png", "--board", "IMG_1.png"]) == 1
    assert "this is no board.json" in capsys.readouterr().err
    assert main(["calibrate", "no.png", *board]) == 1
    assert "no.png" in capsys.readouterr().err


def test_a_camera_of_the_command_is_one_to_adjust_with(there, tmp_path):
    out = str(tmp_path / "c.json")
    main(["calibrate", "*.png", "--board", "board.json", "--camera", out])
    photos, points = tmp_path / "photos.txt", tmp_path / "points.txt"
    image = tmp_path / "image.txt"
    photos.write_text("1 0 0 0 0 0 9\n2 0 0 0 1 0 9\n")
    points.write_text("".join(f"{i} {i % 3} {i // 3} {i % 2}\n" for i in range(9)))
    image.write_text(
        "".join(f"{i} {j} 0.01 0.02 0.001 0.001\n" for i in range(9) for j in (1, 2))
    )
    network = bundle.read(out, photos, points, image)
    assert network.cameras[0] == camera.Camera.read(out)
