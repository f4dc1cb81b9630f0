"""The image pyramid: each level half the size of the one below."""

import cv2
import numpy as np

from pgm_lab.stereo._boxes import Image

LEAST = 40  # px: the smallest side of a level on which windows still tell places apart


def levels_of(shape: tuple[int, ...], most: int) -> int:
    """How many levels an image bears."""
    return max(1, min(most, int(np.log2(max(min(shape), 1) / LEAST)) + 1))


def pyramid(image: Image, levels: int) -> list[Image]:
    """Levels from fine to coarse; what is masked has no part in the means."""
    out = [image]
    for _ in range(levels - 1):
        grey, mask = out[-1]
        share = cv2.pyrDown(mask)
        mask = (share > 0.5).astype(np.float32)
        out.append(Image(cv2.pyrDown(grey) / np.maximum(share, 0.5) * mask, mask))
    return out


def finer(d: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Disparities of a level as start values of the level below."""
    d = cv2.medianBlur(d, 5)
    return 2 * cv2.resize(d, shape[::-1], interpolation=cv2.INTER_LINEAR)


def filled(d: np.ndarray, good: np.ndarray) -> np.ndarray:
    """Disparities with the bad ones from the mean of good ones as near as there are."""
    w = good.astype(np.float32)
    if good.all() or min(d.shape) < 3:
        all_of_them = float((d * w).sum() / max(w.sum(), 1))
        return np.where(good, d, np.float32(all_of_them)).astype(np.float32)
    share = cv2.pyrDown(w)
    mean = cv2.pyrDown(d * w) / np.maximum(share, 1e-3)
    coarse = filled(mean, share > 1e-3)
    near = cv2.resize(coarse, d.shape[::-1], interpolation=cv2.INTER_LINEAR)
    return np.where(good, d, near).astype(np.float32)
