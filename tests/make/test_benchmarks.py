"""The ratios that `make benchmark` prints; the times themselves are not tested."""

import importlib.util

from pgm_book.make.environment import ROOT

PLACE = ROOT / "tests" / "benchmarks" / "conftest.py"


def test_ratios_are_those_of_the_medians_to_the_first_of_each_group():
    spec = importlib.util.spec_from_file_location("benchmarks_conftest", PLACE)
    conftest = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(conftest)
    medians = {
        "a million points": {"test_ours": 0.02, "test_peer": 0.05, "test_loop": 2.0},
        "one point": {"test_alone": 1e-6},
    }
    assert [line.split() for line in conftest.ratios(medians)] == [
        [],
        ["a", "million", "points"],
        ["20", "ms", "test_ours"],
        ["2.5", "x", "test_peer"],
        ["100", "x", "test_loop"],
        [],
        ["one", "point"],
        ["0.001", "ms", "test_alone"],
    ]
