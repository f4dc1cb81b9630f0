"""No check of an exercise leaks an error, or takes an answer that makes no sense."""

import importlib
import inspect
import re
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest

from pgm_book.common.checks import CheckFailed
from tests import good_arguments

ARRAYS = {
    f"{what} {shape}": np.full(shape, value)
    for shape in ((), (2,), (3,), (3, 3), (6,))
    for what, value in (("NaN", np.nan), ("inf", np.inf))
}
ANSWERS = ARRAYS | {
    "None": None,
    "nothing yet": ...,
    "text": "text",
    "text of a number": "1.0",
    "list of texts": ["a", "b"],
    "dictionary": {"a": 1},
    "object": object(),
    "complex": 1j,
    "type": int,
    "a number": -12345.6,
    "empty": [],
    "ragged": [[1.0, 2.0], [3.0]],
    "complex numbers": np.full(2, 1j),
    "masked numbers": np.ma.masked_all(2),
    "dates": np.full(2, "2020-01-01", "M8[D]"),
    "objects": np.array([None, "1"]),
}


def functions():
    """Bad functions of a reader."""

    def raising(error):
        def mine(*_):
            raise error

        return mine

    for label, answer in ANSWERS.items():
        yield f"returns {label}", lambda *_, answer=answer: answer
    for error in (RuntimeError("wrong"), ValueError(), KeyError("x")):
        yield f"raises {error!r}", raising(error)
    yield "takes nothing", lambda: 1.0
    yield "NaN like the first", lambda *a: np.full(np.shape(a[0]), np.nan)
    yield "NaN like the last", lambda *a: np.full(np.shape(a[-1]), np.nan)
    yield "warns", lambda *a: np.array([np.log(-1.0)] * 3)
    for label in ("None", "text", "a number", "dictionary"):
        yield f"is {label}", ANSWERS[label]


def checks():
    """All checks that a notebook calls, by lesson, module and name."""
    root = Path(__file__).parents[2]
    texts = [p.read_text(encoding="utf-8") for p in root.glob("notebooks/*.ipynb")]
    calls = set(re.findall(r"\b(chapter\w+)\.(\w+)\(", "".join(texts)))
    for path in sorted(root.glob("pgm_book/ch*/*checks.py")):
        chapter, module = path.parent.name, path.stem
        home = importlib.import_module(f"pgm_book.{chapter}.{module}")
        called = (
            f"chapter{chapter[2:].lstrip('0') or 0}{'c' * module.startswith('case')}"
        )
        for name in sorted(name for checks, name in calls if checks == called):
            yield f"{chapter}.{module}.{name}", getattr(home, name)


def given(full):
    """What a check is given by the notebook, not by the reader."""
    dx, dy = np.array([(3.0, 0), (1, -3), (0, 2)]).T
    pair, land = good_arguments.normal_pair(), good_arguments.level_land()
    return {
        "ch07.checks.border": dict(dx=dx, dy=dy, radius=3),
        "ch08.checks.mark": dict(pair=pair, place=(30, 30), land=land),
        "ch08.case_checks.marks": dict(
            pair=pair, places=np.full((1, 2), 30), land=land
        ),
    }.get(full, {})


NO_CHECKS = {"ch06.case_checks.rescaled"}  # makes the matrices that a check compares
GOOD = {  # of checks of several answers: the others
    "ch00.checks.tenth": dict(point=10, computed=(2.24795, 3.53131)),
    "ch06.case_checks.largest_difference": dict(
        photo=1, unknown="kappa", unit="rad", moved_um=1.0
    ),
    "ch07.case_checks.constructed": dict(shifts=np.ones((50, 2)), mean=(1, 0)),
}


CHECKS = {full: one for full, one in checks() if full not in NO_CHECKS}


SLOW = {"ch09.checks.flat_board", "ch09.checks.surface_point"}  # they adjust each time
ALL = [pytest.param(one, marks=[pytest.mark.slow] * (one in SLOW)) for one in CHECKS]


@pytest.mark.parametrize("full", ALL)
def test_a_check_names_what_fails_and_never_leaks(full):
    check, known, found = CHECKS[full], given(full), []
    for name in inspect.signature(check).parameters:
        if name in known:
            continue
        bads = dict(functions()) if name == "function" else ANSWERS
        for label, bad in bads.items():
            try:
                with np.errstate(all="ignore"):
                    check(**known | GOOD.get(full, {}) | {name: bad})
                found.append(f"{name}, {label}: accepted")
            except CheckFailed:
                pass
            except Exception as error:
                found.append(f"{name}, {label}: leaks {error!r}")
            plt.close("all")
    assert found == [], "\n".join(found)
