"""What the rounding of numbers does to residuals, wherever the object stands."""

from types import SimpleNamespace

import numpy as np
import pytest

from pgm_lab.bundle import solve


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("far", ["exteriors", "points"])
def test_rounding_is_that_of_the_largest_number_on_either_side_of_the_origin(far, sign):
    state = SimpleNamespace(
        interior=np.zeros((1, 10)), exteriors=np.ones((2, 6)), points=np.ones((4, 3))
    )
    getattr(state, far)[1, 2] = sign * 5e6
    problem = SimpleNamespace(
        estimated=[], held=np.zeros((3, 4), bool), rays=SimpleNamespace(level=0.0)
    )
    # A coordinate moves a residual by two of its standard deviations
    reduced = SimpleNamespace(diagonal=np.full(12, 4.0), V_diagonal=np.full((3, 4), 4))
    found = solve._rounding(problem, state, reduced)
    assert found == pytest.approx(solve.ROUNDING * 2 * 5e6)
    # What is held is not moved
    problem.held[2, 1] = True
    held = solve._rounding(problem, state, reduced)
    assert held == pytest.approx(solve.ROUNDING * 2 if far == "points" else found)
