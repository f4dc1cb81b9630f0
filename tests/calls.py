"""Calls of a command line: what it says when it fails, and files that are no images."""

import struct
import zlib

import matplotlib.pyplot as plt
import numpy as np
import pytest
from PIL import Image

from pgm_lab.io import files as _files

HOW = {
    "disk full": (OSError(28, "No space left on device"), "No space left"),
    "interrupted": (KeyboardInterrupt(), "interrupted"),
    "memory": (MemoryError(), "not enough memory for these"),
}


class Call:
    """A command by its `main` and the name it goes by."""

    def __init__(self, main, name):
        self.main, self.name = main, name

    def run(self, *arguments):
        return self.main([str(one) for one in arguments])

    def ended(self, capsys, *arguments):
        """Return the one line with which the command fails."""
        assert self.run(*arguments) == 1
        output = capsys.readouterr()
        assert output.out == "" and "Traceback" not in output.err
        (message,) = output.err.splitlines()
        assert message.isprintable() and len(message) < 700
        assert message.startswith(f"{self.name}: ")
        return message

    def refused(self, capsys, *arguments):
        """Return what a wrong call says; it ends with 2 and prints nothing else."""
        with pytest.raises(SystemExit) as end:
            self.run(*arguments)
        output = capsys.readouterr()
        assert end.value.code == 2 and output.out == ""
        assert "Traceback" not in output.err
        return " ".join(output.err.split())


def break_(monkeypatch, where, how, functions):
    """Have a function raise, or a file break off while it is written or renamed."""

    def fails(*_, **__):
        raise HOW[how][0]

    if where in functions:
        monkeypatch.setattr(*functions[where], fails)
        return
    name = "open" if where == "writing" else "replace"
    original = getattr(_files.Path, name)

    def method(self, *arguments, **options):
        if self.suffix == ".part" and arguments[:1] != ("r",):
            if name == "open":
                with original(self, *arguments, **options) as file:
                    file.write(b"<!DOC" if "b" in arguments[0] else "<!DOC")
            fails()
        return original(self, *arguments, **options)

    monkeypatch.setattr(_files.Path, name, method)


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


def image(values):
    return lambda path: Image.fromarray(values).save(path, "PNG")


def tiff(values):
    return lambda path: Image.fromarray(values).save(path, "TIFF")


def drawn(figure):
    """What stands for a picture, whose drawing takes longer than all the rest."""
    plt.close(figure)
    return str(figure.get_size_inches())
