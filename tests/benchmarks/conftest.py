"""One thread for all, and at the end the ratios within each group.

Compare programs by a ratio of two times from the same run: times of their own change
with the machine, and with what else it has to do. The first test of a group is ours.
"""

import os
from collections import defaultdict

import cv2
import pytest

MEDIANS: dict[str, dict[str, float]] = defaultdict(dict)


@pytest.fixture(scope="session", autouse=True)
def one_thread():
    """Whoever computes on all cores would be compared with whoever does not."""
    if os.environ.get("OMP_NUM_THREADS") != "1":
        pytest.exit("numpy may use several threads: start it as make benchmark", 2)
    cv2.setNumThreads(1)
    assert cv2.getNumThreads() == 1


@pytest.fixture(autouse=True)
def noted(request, benchmark):
    """Note the median that a test has measured."""
    yield
    if benchmark.stats:  # not with --benchmark-disable
        group = benchmark.group or request.node.name
        MEDIANS[group][request.node.name] = benchmark.stats.stats.median


@pytest.hookimpl(trylast=True)  # below the tables of pytest-benchmark
def pytest_terminal_summary(terminalreporter):
    """Print how many times as long as ours the others take."""
    if MEDIANS:
        terminalreporter.section("medians, as ratios to the first of the group")
    for line in ratios(MEDIANS):
        terminalreporter.write_line(line)


def ratios(medians: dict[str, dict[str, float]]) -> list[str]:
    """Lines with the median of the first test of each group, and the others' ratios."""
    lines = []
    for group, times in medians.items():
        (ours, unit), *others = times.items()
        lines += ["", group, f"  {1000 * unit:10.3g} ms  {ours}"]
        lines += [f"  {time / unit:10.3g} x   {name}" for name, time in others]
    return lines
