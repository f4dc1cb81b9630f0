"""Calls of the command, and files that are no images."""

from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from PIL import Image

from pgm_lab.command import main

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
    """Have a function raise, or the second file break off while it is renamed."""

    def fails(*_, **__):
        raise HOW[how][0]

    if where in functions:
        monkeypatch.setattr(*functions[where], fails)
        return
    replace, calls = Path.replace, []

    def second_fails(self, target):
        calls.append(self)
        return fails() if len(calls) == 2 else replace(self, target)

    monkeypatch.setattr(Path, "replace", second_fails)


# --- Files that are no images ---


def image(values, kind="PNG"):
    return lambda path: Image.fromarray(values).save(path, kind)


def tiff(values):
    return image(values, "TIFF")


# What may be in the place of an image, and what the message says of it; tests/io tries
# the rest
NO_IMAGE = {
    "text": (lambda path: path.write_text("1 2 3\n" * 9), "not an image"),
    "one pixel": (image(np.zeros((1, 1), np.uint8)), ""),
    "one row": (image(np.zeros((1, 240), np.uint8)), ""),
    "featureless": (image(np.full((160, 200), 99, np.uint8)), ""),
    "nothing but NaN": (tiff(np.full((160, 200), np.nan, np.float32)), "no data"),
}


def drawn(figure):
    """What stands for a picture, whose drawing takes longer than all the rest."""
    plt.close(figure)
    return str(figure.get_size_inches())
