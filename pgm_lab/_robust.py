"""The standard deviation of errors among which there are blunders."""

import numpy as np

SD_OF_MAD = 1.4826  # sd of a normal distribution over its median absolute deviation


def nmad(errors: np.ndarray, axis: int | None = None) -> np.ndarray:
    """1.4826 times the median distance from the median: sd of normal errors."""
    middle = np.median(errors, axis=axis, keepdims=True)
    return SD_OF_MAD * np.median(np.abs(errors - middle), axis=axis)
