"""Calls of the command, and files that are no images."""

import struct
import zlib
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from PIL import Image

from pgm_lab.command import main
from pgm_lab.io import files as _files

HOW = {
    "disk full": (OSError(28, "No space left on device"), "No space left"),
    "interrupted": (KeyboardInterrupt(), "interrupted"),
    "memory": (MemoryError(), "not enough memory for th"),
}


@dataclass
class Call:
    """A subcommand, the files that it reads, and how what it prints begins."""

    name: str
    inputs: list[Path]
    begins: str = ""

    def run(self, *more, inputs=None):
        """Return the exit code."""
        words = self.inputs if inputs is None else inputs
        return main([self.name, *map(str, words), *map(str, more)])

    def ended(self, capsys, *more, inputs=None):
        """Return the one line with which the command fails."""
        assert self.run(*more, inputs=inputs) == 1
        output = capsys.readouterr()
        assert output.out == "" and "Traceback" not in output.err
        (message,) = output.err.splitlines()
        assert message.isprintable() and len(message) < 700
        assert message.startswith(f"pgm_lab {self.name}: ")
        return message

    def refused(self, capsys, *more, inputs=None):
        """Return what a wrong call says; it ends with 2 and prints nothing else."""
        with pytest.raises(SystemExit) as end:
            self.run(*more, inputs=inputs)
        output = capsys.readouterr()
        assert end.value.code == 2 and output.out == ""
        assert "Traceback" not in output.err and "\x1b" not in output.err
        return " ".join(output.err.split())


def break_(monkeypatch, where, how, functions):
    """Have a function raise, or a file break off while it is written or renamed."""

    def fails(*_, **__):
        raise HOW[how][0]

    if where in functions:
        monkeypatch.setattr(*functions[where], fails)
        return
    name = "open" if where == "writing" else "replace"
    original, calls = getattr(_files.Path, name), []

    def method(self, *arguments, **options):
        if self.suffix == ".part" and arguments[:1] != ("r",):
            calls.append(self)
            if where != "renaming the second" or len(calls) == 2:
                if name == "open":
                    with original(self, *arguments, **options) as file:
                        file.write(b"<!DOC" if "b" in arguments[0] else "<!DOC")
                fails()
        return original(self, *arguments, **options)

    monkeypatch.setattr(_files.Path, name, method)


# --- Files that are no images ---


def chunk(kind, data):
    whole = kind + data
    return struct.pack(">I", len(data)) + whole + struct.pack(">I", zlib.crc32(whole))


def huge_header():
    """A PNG that says it has 60000 x 60000 pixels, and holds hardly any."""
    head = struct.pack(">IIBBBBB", 60000, 60000, 8, 0, 0, 0, 0)
    body = chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(b"\0" * 99))
    return b"\x89PNG\r\n\x1a\n" + body + chunk(b"IEND", b"")


def truncated_jpeg(path):
    rng = np.random.default_rng(4)
    values = rng.integers(0, 255, (200, 240), np.uint8)
    Image.fromarray(values).save(path, "JPEG")
    path.write_bytes(path.read_bytes()[:3000])


def image(values, kind="PNG"):
    return lambda path: Image.fromarray(values).save(path, kind)


def tiff(values):
    return image(values, "TIFF")


# What may be in the place of an image, and what the message says of it
NO_IMAGE = {
    "missing": (lambda path: path.unlink(), "there is no such file"),
    "empty": (lambda path: path.write_bytes(b""), "the file is empty"),
    "text": (lambda path: path.write_text("1 2 3\n" * 9), "not an image"),
    "a web page": (lambda path: path.write_text("<html></html>"), "not an image"),
    "truncated": (truncated_jpeg, "damaged"),
    "a folder": (lambda path: (path.unlink(), path.mkdir()), "this is a folder"),
    "huge header": (lambda path: path.write_bytes(huge_header()), ""),
    "one pixel": (image(np.zeros((1, 1), np.uint8)), ""),
    "one row": (image(np.zeros((1, 240), np.uint8)), ""),
    "nothing but NaN": (tiff(np.full((160, 200), np.nan, np.float32)), "no data"),
}

# What may be in the place of points, and what the message says of it
NO_POINTS = {
    "not a number": ("10 20\n30 x\n", "line 2: 'x' is not a number"),
    "a heading": ("column row\n10 20\n", "line 1: 'column' is not a number; a heading"),
    "three columns": ("1 10 20\n", "3 column(s), where points have 2: column row"),
    "one column": ("10\n", "1 column(s)"),
    "decimal comma": ("10,5 20,5\n", "decimal comma"),
    "nan": ("10 20\nnan 5\n", "line 2: 'nan' is not a number; leave out the line"),
    "no numbers": ("% column row\n", "the file holds no numbers"),
    "empty": ("", "the file "),
    "a picture": ("\x89PNG\0\n", "this is not text"),
}


def drawn(figure):
    """What stands for a picture, whose drawing takes longer than all the rest."""
    plt.close(figure)
    return str(figure.get_size_inches())
