"""pgm_lab board: the page, what is written beside it, and that both fit together."""

import re
import shutil
import subprocess

import cv2
import numpy as np
import pytest

from pgm_lab.calibration.board import KINDS, PAPERS, Board
from pgm_lab.calibration.detect import detect
from pgm_lab.command import main


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def refused(capsys, *words):
    """What a wrong call says."""
    with pytest.raises(SystemExit) as end:
        main(["board", *words])
    assert end.value.code == 2
    return " ".join(capsys.readouterr().err.split())


def test_a_page_and_its_file_are_written_and_what_to_do_is_said(folder, capsys):
    assert main(["board", "board.pdf"]) == 0
    output = capsys.readouterr()
    assert sorted(p.name for p in folder.iterdir()) == ["board.json", "board.pdf"]
    assert (folder / "board.pdf").read_bytes().startswith(b"%PDF")
    board = Board.read("board.json")
    assert (board.kind, len(board.points), len(board.bars)) == ("charuco", 96, 4)
    for words in ("at 100 %", "Photograph it 15 times", "--board board.json --report"):
        assert words in output.out
    assert output.err == ""


@pytest.mark.slow
def test_numbers_kind_and_names_are_those_asked_for(folder):
    words = "--kind chequerboard --columns 8 --rows 5 --square 30 --paper A3"
    assert main(["board", "a.pdf", *words.split(), "--json", "b.json"]) == 0
    board = Board.read("b.json")
    asked = board.kind, board.columns, board.rows, board.square
    assert asked == ("chequerboard", 8, 5, 30)


@pytest.mark.parametrize("kind", KINDS)
def test_what_a_screen_shows_is_found_in_a_photo_of_it(folder, kind, capsys):
    words = ["--screen", "1920x1080", "--kind", kind.replace(" ", "-")]
    assert main(["board", "board.png", *words]) == 0
    shown = cv2.imread("board.png", cv2.IMREAD_GRAYSCALE)
    board = Board.read("board.json")
    found = detect(shown, board)
    assert found.reason == "" and len(found.ids) == len(board.points)
    # In proportion: all that a ruler does not say
    steps = np.diff(found.pixels, axis=0) @ np.diag((1, -1)) * 25.4 / 96
    np.testing.assert_allclose(steps, np.diff(board.points[:, :2], axis=0), atol=0.4)
    assert "--square MM" in capsys.readouterr().out


@pytest.mark.skipif(shutil.which("pdftoppm") is None, reason="renders the page")
@pytest.mark.parametrize("paper", PAPERS)
def test_the_printed_board_has_its_true_size_where_it_is_found(folder, paper):
    """Another program's picture of the page, at 150 pixels an inch."""
    assert main(["board", "board.pdf", "--paper", paper]) == 0
    render = ["pdftoppm", "-r", "150", "-gray", "-png", "board.pdf", "page"]
    subprocess.run(render, check=True)
    (path,) = folder.glob("page*.png")
    page = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    board = Board.read("board.json")
    found = detect(page, board)
    at = found.pixels @ np.diag((1, -1)) * 25.4 / 150
    at, points = at - at.mean(0), board.points[:, :2] - board.points[:, :2].mean(0)
    np.testing.assert_allclose(at, points, atol=0.05)
    assert np.sum(at * points) / np.sum(points**2) == pytest.approx(1, abs=1e-4)


@pytest.mark.parametrize(
    "words, message",
    [
        (["board.png"], "board.png: the name must end in .pdf"),
        (["board.pdf", "--screen", "1920x1080"], "the name must end in .png"),
        (["a.png", "--screen", "1920"], "'1920' is not a size such as 1920x1080"),
        (["a.png", "--screen", "900x900", "--square", "3"], "it is measured; leave it"),
        (["board.pdf", "--kind", "chess"], "invalid choice: 'chess'"),
        (["board.pdf", "--json", "board.pdf"], "the name must end in .json"),
        (["no/board.pdf"], "there is no folder no"),
    ],
)
def test_a_wrong_call_ends_with_2(folder, capsys, words, message):
    assert message in refused(capsys, *words)
    assert not list(folder.iterdir())


@pytest.mark.parametrize(
    "words, message",
    [
        (["--square", "25"], "13 x 9 with 25 mm do not fit: A4 leaves 265 x 180"),
        (["--columns", "40"], "needs 180 markers, DICT_5X5_100 has 100"),
        (["--rows", "2"], "rows must be a whole number, at least 3; got 2"),
        (["--square", "10", "--marker", "10"], "must be smaller than square"),
        (["--kind", "circles", "--columns", "9"], "its numbers must differ"),
    ],
)
def test_a_board_that_cannot_be_ends_with_1(folder, capsys, words, message):
    assert main(["board", "board.pdf", *words]) == 1
    error = capsys.readouterr().err
    assert message in error and re.fullmatch(r"pgm_lab board: .+\n", error)
    assert not list(folder.iterdir())


def test_nothing_is_replaced_without_force(folder, capsys):
    (folder / "board.json").write_text("measured")
    message = refused(capsys, "board.pdf")
    assert "--json board.json: it exists already; --force replaces it" in message
    assert (folder / "board.json").read_text() == "measured"
    assert main(["board", "board.pdf", "--force"]) == 0
