"""How far a match can be trusted: a placeholder, the correlation of its windows."""

import numpy as np


def quality(r: np.ndarray) -> np.ndarray:
    """Between 0 and 1 for each match; NaN stays NaN."""
    return np.clip(np.abs(r), 0, 1)
