"""Files of users: what exists is kept, what is written is complete or not there."""

import os
from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest

from pgm_lab import (
    bundle,
    matching,
    observations,
    registration,
    simulate,
    stereo,
    stereo_map,
)
from pgm_lab.io import files
from tests.networks import small

POSIX = pytest.mark.skipif(os.name == "nt", reason="modes and pipes of POSIX")


@pytest.fixture
def old(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("mine")
    return path


def names(folder):
    return sorted(one.name for one in folder.iterdir())


def test_texts_and_bytes_are_written_as_they_are(tmp_path):
    """UTF-8 with the line ends given, on Windows too, in a folder that is made."""
    paths = tmp_path / "new" / "µ.csv", tmp_path / "new" / "b.bin"
    files.save({str(paths[0]): "µ\r\n1\n", paths[1]: b"\0\n"})
    assert files.place(paths[0]) == paths[0]
    assert [path.read_bytes() for path in paths] == [b"\xc2\xb5\r\n1\n", b"\0\n"]
    assert names(tmp_path / "new") == ["b.bin", "µ.csv"]


def test_what_exists_is_replaced_only_when_told(old):
    with pytest.raises(FileExistsError, match=r"a\.csv already exists.*overwrite=True"):
        files.save({old.with_name("new"): "1", old: "new"})
    with pytest.raises(FileExistsError), files.atomic(old):
        raise AssertionError("never reached")
    assert names(old.parent) == ["a.csv"] and old.read_text() == "mine"
    files.save({old: "new"}, overwrite=True)
    assert names(old.parent) == ["a.csv"] and old.read_text() == "new"


def test_what_another_program_wrote_meanwhile_stays(tmp_path):
    path = tmp_path / "a.csv"
    with pytest.raises(FileExistsError), files.atomic(path) as part:
        part.write_text("ours")
        path.write_text("theirs")
    assert names(tmp_path) == ["a.csv"] and path.read_text() == "theirs"


@POSIX
def test_the_mode_is_kept_and_a_new_file_has_the_usual_one(old):
    old.chmod(0o640)
    files.save({old: "new", old.with_name("b.csv"): ""}, overwrite=True)
    usual = old.with_name("usual")
    usual.touch()
    modes = [p.stat().st_mode & 0o777 for p in (old, old.with_name("b.csv"), usual)]
    assert modes == [0o640, modes[2], modes[2]]


def test_a_write_protected_file_stays(old):
    old.chmod(0o444)
    with pytest.raises(PermissionError, match=r"a\.csv is write-protected"):
        files.save({old: "new"}, overwrite=True)
    assert old.read_text() == "mine"
    old.chmod(0o644)  # or Windows cannot remove it


@POSIX
def test_a_link_stays_and_its_target_is_written(old, tmp_path):
    link, dangling = tmp_path / "link", tmp_path / "dangling"
    link.symlink_to("a.csv")
    dangling.symlink_to("b.csv")
    with pytest.raises(FileExistsError):
        files.save({link: "new"})
    files.save({link: "new", dangling: "b"}, overwrite=True)
    assert os.readlink(link) == "a.csv" and os.readlink(dangling) == "b.csv"
    assert old.read_text() == "new" and (tmp_path / "b.csv").read_text() == "b"


@POSIX
def test_folders_pipes_and_devices_are_neither_replaced_nor_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    before = os.stat("/dev/null")
    for path in (tmp_path / "pipe", "/dev/null"):
        with pytest.raises(OSError, match="a pipe or a device; name a file"):
            files.save({path: "x"}, overwrite=True)
        with pytest.raises(OSError, match="a pipe or a device; save its content"):
            files.content(path, "photo")
    assert os.stat("/dev/null").st_rdev == before.st_rdev
    for path in (tmp_path, "."):
        with pytest.raises(IsADirectoryError, match="this is a folder; name a file"):
            files.save({path: "x"}, overwrite=True)
    (tmp_path / "file").touch()
    with pytest.raises(NotADirectoryError, match="file is not a folder"):
        files.save({tmp_path / "file" / "a.csv": "x"})
    assert names(tmp_path) == ["file", "pipe"]


def test_a_tilde_is_the_home_of_the_user_and_a_drive_no_address(tmp_path, monkeypatch):
    for name in ("HOME", "USERPROFILE"):
        monkeypatch.setenv(name, str(tmp_path))
    files.save({"~/a.csv": "1"})
    assert names(tmp_path) == ["a.csv"] and files.content("~/a.csv", "a") == b"1"
    assert files.local("C:/data/a.csv", "path") == Path("C:/data/a.csv")


def test_a_name_that_the_system_refuses_is_named_and_not_repeated_whole(tmp_path):
    for path in (tmp_path / ("x" * 5000), tmp_path / ("y/" * 3000)):
        with pytest.raises(OSError, match="it cannot be written") as caught:
            files.save({path: "x"})
        assert str(tmp_path)[:50] in str(caught.value) and len(str(caught.value)) < 300
    assert names(tmp_path) == []


# --- What all have in common that save: the one writer ---


@cache
def session():
    pair = simulate.aerial_pair((240, 180))
    opened = stereo_map.open_pair(pair.left, pair.right)
    return stereo_map.add(opened, stereo_map.measure(opened, (100, 80)))


def cloud():
    xyz, sd = np.random.default_rng(1).uniform(1, 9, (2, 50, 3))
    return stereo.Points(xyz, sd, np.ones(50), np.ones((50, 2)))


GREY = np.random.default_rng(2).integers(0, 255, (90, 90)).astype(np.uint8)
WRITERS = {  # a name that each takes, and what it saves with what else it is told
    bundle.write: ("new", small),
    observations.Observations.save: ("a", lambda: stereo_map.observations(session())),
    stereo_map.save: ("a", session),
    stereo_map.save_network: ("new", session),
    matching.Match.save: ("a", lambda: matching.match(GREY, GREY, number=4)),
    registration.Registration.save: (
        "a",
        lambda: registration.register(GREY, GREY, [(40, 40)]),
    ),
    stereo.save_points: ("a.csv", cloud),
    stereo.save_surface: ("a.csv", lambda: stereo.surface(cloud().xyz, 1.0)),
}
every_writer = pytest.mark.parametrize(
    "save, name, make",
    [(save, *row) for save, row in WRITERS.items()],
    ids=lambda one: getattr(one, "__qualname__", ""),
)


@every_writer
def test_whatever_is_saved_goes_through_the_one_writer(
    save, name, make, tmp_path, monkeypatch
):
    save = partial(save, make())
    monkeypatch.chdir(tmp_path)
    for home in ("HOME", "USERPROFILE"):
        monkeypatch.setenv(home, str(tmp_path))
    for wrong in ("no", 1, None):
        with pytest.raises(ValueError, match="overwrite must be True or False"):
            save(name, overwrite=wrong)
    for path, message in {
        f"https://a.org/{name}": "on this computer; got the address",
        "": "must be the name of a f",
        3: "must be the name of a f",
        f"a\0{name}": "a null character",
    }.items():
        with pytest.raises(ValueError, match=message):
            save(path)
    with pytest.raises(OSError, match="it cannot be written"):
        save("x" * 300 + name)
    Path("file").touch()
    with pytest.raises(OSError, match="file is not a folder"):
        save("file" if name == "new" else f"file/{name}")
    assert names(tmp_path) == ["file"]
    save(f"~/{name}", overwrite=np.bool_(False))
    assert names(tmp_path) == sorted(["file", name])
    with pytest.raises(FileExistsError, match="already exists"):
        save(name)
    save(name, overwrite=np.bool_(True))


@POSIX
@every_writer
def test_a_full_disk_names_the_file_and_leaves_the_old_one(save, name, make, tmp_path):
    """Files of this process may not have more than a few bytes, for a moment."""
    import resource

    save = partial(save, make())
    save(tmp_path / name)
    files_before = {p: p.read_bytes() for p in tmp_path.rglob("*") if p.is_file()}
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20, hard))
    try:
        with pytest.raises(OSError) as caught:
            save(tmp_path / name, overwrite=True)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    message = str(caught.value)
    assert str(tmp_path / name) in message and "it cannot be written (" in message
    assert ".part" not in message
    after = {p: p.read_bytes() for p in tmp_path.rglob("*") if p.is_file()}
    assert after == files_before


# --- A set of files ---


@pytest.mark.parametrize("error", [OSError(28, "No space left"), KeyboardInterrupt()])
@pytest.mark.parametrize("step", ["open", "replace"])
@pytest.mark.parametrize("nth", range(3))
def test_a_set_is_replaced_as_a_whole(old, monkeypatch, step, nth, error):
    """Whichever file the disk is full at, or the user interrupts."""
    paths = [old, old.with_name("b.csv"), old.with_name("c.csv")]  # b is new
    paths[2].write_text("mine too")
    original, calls = getattr(Path, step), []

    def fails(self, *arguments, **options):
        if self.suffix == ".part" and arguments[:1] != ("r",):
            calls.append(self)
            if len(calls) == nth + 1:
                raise error
        return original(self, *arguments, **options)

    with monkeypatch.context() as patch:
        patch.setattr(Path, step, fails)
        with pytest.raises(type(error)):
            files.save(dict.fromkeys(paths, "new"), overwrite=True)
    assert names(old.parent) == ["a.csv", "c.csv"]
    assert [old.read_text(), paths[2].read_text()] == ["mine", "mine too"]
    files.save(dict.fromkeys(paths, "new"), overwrite=True)
    assert names(old.parent) == ["a.csv", "b.csv", "c.csv"]
    assert [path.read_text() for path in paths] == ["new"] * 3


@pytest.mark.parametrize(
    "make, error, message",
    [
        (lambda path: None, FileNotFoundError, "points: there is no such file"),
        (Path.mkdir, IsADirectoryError, "points: this is a folder, not a file"),
        (Path.touch, ValueError, "points: the file is empty"),
        pytest.param(
            *(lambda path: path.symlink_to(path), OSError, "it cannot be read"),
            marks=POSIX,
        ),
    ],
)
def test_files_that_cannot_be_read(tmp_path, make, error, message):
    make(tmp_path / "a")
    with pytest.raises(error, match=message):
        files.existing(tmp_path / "a", "points")


def test_nothing_in_a_name_reaches_the_terminal_as_a_command():
    assert files.printable("Foto ä日\x1b[2J\n.png") == "Foto ä日\\x1b[2J\\n.png"
