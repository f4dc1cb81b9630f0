"""What holds for every run of pytest, from every folder."""

import gc
import random

import pytest

pytest_plugins = ["tests.left_behind"]
# They import each other where they run: in the box, in a zip, in nbgrader
collect_ignore_glob = ["pgm_book/course/boxed/*", "pgm_book/course/templates/*"]


def pytest_addoption(parser):
    """Let a run be put into another order."""
    parser.addoption(
        "--shuffle", type=int, metavar="SEED", help="files and tests in a random order"
    )


def pytest_configure(config):
    """Read the path in pyproject.toml from the project's folder, for nbval."""
    path = config.getoption("nbval_sanitize_with", None)
    if path:
        config.option.nbval_sanitize_with = str(config.rootpath / path)


def pytest_terminal_summary(terminalreporter, config):
    """Say how a shuffled run is repeated."""
    seed = config.getoption("shuffle")
    if seed is not None:
        terminalreporter.write_line(f"Shuffled; the same order: --shuffle={seed}")


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Let `--dist load` spread single tests, but keep each notebook on one worker."""
    if config.getvalue("dist") != "load":
        return None
    from xdist.scheduler import LoadScopeScheduling

    class Spread(LoadScopeScheduling):
        def _split_scope(self, nodeid):
            file = nodeid.partition("::")[0]
            return file if file.endswith(".ipynb") else nodeid

    return Spread(config, log)


def pytest_collection_modifyitems(config, items):
    """Begin with the longest files, or shuffle; keep each notebook whole."""
    files = {}
    for item in items:
        files.setdefault(item.path, []).append(item)
    order = sorted(files, key=lambda path: not is_long(path))
    seed = config.getoption("shuffle")
    if seed is not None:
        dice = random.Random(seed)
        dice.shuffle(order)
        for path in order:
            if not is_notebook(path):  # its cells build on each other
                dice.shuffle(files[path])
    items[:] = [item for path in order for item in files[path]]


def pytest_collection_finish():
    """Leave the tests, which stay to the end, out of every search for waste."""
    gc.freeze()


def is_notebook(path):
    """Whether the tests of a file are the cells of a notebook."""
    return path.suffix == ".ipynb"


def is_long(path):
    """Whether the tests of a file need a kernel, or all handouts, for long."""
    return is_notebook(path) or path.name in (
        "test_student.py",
        "test_chapter.py",
        "test_lab.py",
        "test_handouts.py",
    )
