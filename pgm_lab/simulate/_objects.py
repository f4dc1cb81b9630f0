"""What stands on the ground or is drawn on it: each in its own small window."""

import dataclasses
from dataclasses import dataclass

import cv2
import numpy as np

OPEN, BUILDING, TREE, WATER = 0, 1, 2, 3
GRAIN = 512  # cells, side of the random field that roofs and crowns take theirs from


def grain(sigma: float) -> np.ndarray:
    """Random field (rows, columns), sd 1, smooth over so many cells; its edges meet."""
    white = np.random.default_rng(0).standard_normal((GRAIN, GRAIN), np.float32)
    around = np.pad(white, 16, mode="wrap")
    smooth = cv2.GaussianBlur(around, (0, 0), sigma)[16:-16, 16:-16]
    return smooth / smooth.std()


@dataclass(frozen=True, eq=False)
class Site:
    """Layers of a landscape while it is built; see `Landscape`."""

    grey: np.ndarray
    dtm: np.ndarray
    dsm: np.ndarray
    kind: np.ndarray
    cell: float
    paved: np.ndarray
    fine: np.ndarray = dataclasses.field(default_factory=lambda: grain(0.8))
    coarse: np.ndarray = dataclasses.field(default_factory=lambda: grain(2.5))

    def window(self, row: float, column: float, reach: float) -> tuple[slice, slice]:
        """Window of so many cells around a place, as far as it is inside."""
        rows, columns = self.dtm.shape
        a, b = max(0, int(row - reach)), min(rows, int(row + reach) + 2)
        c, d = max(0, int(column - reach)), min(columns, int(column + reach) + 2)
        return slice(a, max(a, b)), slice(c, max(c, d))

    def rough(
        self, window: tuple[slice, slice], rng: np.random.Generator
    ) -> tuple[np.ndarray, np.ndarray]:
        """Random fields for a window, of fine and of coarse grain, sd 1."""
        n, m = (s.stop - s.start for s in window)
        r, c = rng.integers(GRAIN - n + 1), rng.integers(GRAIN - m + 1)
        return self.fine[r : r + n, c : c + m], self.coarse[r : r + n, c : c + m]


def _axes(
    window: tuple[slice, slice], row: float, column: float, angle: float, cell: float
) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates (u along, v across) in m of the cells of a window."""
    r = (np.arange(window[0].start, window[0].stop, dtype=np.float32) - row) * cell
    c = (np.arange(window[1].start, window[1].stop, dtype=np.float32) - column) * cell
    sin, cos = np.sin(angle), np.cos(angle)
    return c * cos + r[:, None] * sin, r[:, None] * cos - c * sin


def field(
    site: Site,
    row: float,
    column: float,
    angle: float,
    size: tuple[float, float],
    rng: np.random.Generator,
) -> None:
    """A field: another tone, more or less of the meadow's texture, perhaps furrows."""
    window = site.window(row, column, np.hypot(*size) / 2 / site.cell)
    u, v = _axes(window, row, column, angle, site.cell)
    within = (np.abs(u) < size[0] / 2) & (np.abs(v) < size[1] / 2)
    if not within.any():
        return
    grey = site.grey[window]
    texture = grey[within] - grey[within].mean()
    tone, keep = rng.uniform(95, 172), rng.uniform(0.5, 1.1)
    furrows = rng.choice([0.0, 4.0, 8.0]) * np.sin(
        2 * np.pi / rng.uniform(1.2, 3.0) * v[within] + rng.uniform(0, 6)
    )
    grey[within] = tone + keep * texture + furrows


def road(site: Site, row: np.ndarray, column: np.ndarray, width: float) -> None:
    """A road along points, brighter than the ground, with little texture."""
    line = np.round(np.stack([column, row], -1) * 16).astype(np.int32)
    mask = np.zeros(site.dtm.shape, np.uint8)
    thick = max(1, round(width / site.cell))
    cv2.polylines(mask, [line], False, 255, thick, cv2.LINE_AA, 4)
    on = mask > 0
    site.paved[on] = True
    share = mask[on] / np.float32(255)
    site.grey[on] = (1 - share) * site.grey[on] + share * (
        182 + 0.3 * (site.grey[on] - 138)
    )


def pond(site: Site, row: float, column: float, radius: float) -> None:
    """Level water of one grey value, in banks that lead smoothly to the ground."""
    window = site.window(row, column, 2.5 * radius / site.cell)
    u, v = _axes(window, row, column, 0.4, site.cell)
    q = np.sqrt(u**2 + (v / 0.6) ** 2) / radius
    level = site.dtm[window][q < 1].mean()
    bank = np.clip((q - 1) / 1.4, 0, 1)
    bank = bank**2 * (3 - 2 * bank)
    site.dtm[window] = level + bank * (site.dtm[window] - level)
    site.dsm[window] = site.dtm[window]
    site.kind[window][q < 1] = WATER
    site.grey[window][q < 1] = 62


def house(
    site: Site, row: float, column: float, angle: float, rng: np.random.Generator
) -> bool:
    """A house with a gable roof or a flat one; False where there is no room."""
    flat = rng.random() < 0.3
    length, width = (
        (rng.uniform(14, 28), rng.uniform(10, 16))
        if flat
        else (rng.uniform(9, 17), rng.uniform(7, 10.5))
    )
    window = site.window(row, column, (np.hypot(length, width) / 2 + 2) / site.cell)
    u, v = _axes(window, row, column, angle, site.cell)
    around = (np.abs(u) < length / 2 + 1.5) & (np.abs(v) < width / 2 + 1.5)
    on = (np.abs(u) < length / 2) & (np.abs(v) < width / 2)
    taken = site.paved[window] | (site.kind[window] != OPEN)
    if not on.any() or taken[around].any():
        return False
    ground = site.dtm[window][on]
    eaves = max(ground.mean() + rng.uniform(3.5, 7.5), ground.max() + 2.5)
    slope = 0.0 if flat else rng.uniform(0.4, 0.8)
    site.dsm[window][on] = eaves + slope * (width / 2 - np.abs(v[on]))
    site.kind[window][on] = BUILDING
    tone = rng.uniform(120, 205) if flat else rng.uniform(80, 165)
    tiles = 0.0 if flat else 4 * np.sin(2 * np.pi * v[on] / 0.9)
    fine, coarse = site.rough(window, rng)
    site.grey[window][on] = tone + 6 * fine[on] + 6 * coarse[on] + tiles
    return True


def tree(site: Site, row: float, column: float, rng: np.random.Generator) -> bool:
    """A tree with a round crown; False where a house or water is."""
    inside = 0 <= row < site.dtm.shape[0] and 0 <= column < site.dtm.shape[1]
    here = int(row), int(column)
    if not inside or site.paved[here] or site.kind[here] in (BUILDING, WATER):
        return False
    height = rng.uniform(5, 16)
    radius = (0.6 + 0.17 * height) * rng.uniform(0.8, 1.2)
    round_, tone = rng.uniform(0.4, 0.9), rng.uniform(80, 135)
    window = site.window(row, column, radius / site.cell)
    u, v = _axes(window, row, column, 0.0, site.cell)
    fine, coarse = site.rough(window, rng)
    q = (u**2 + v**2) / radius**2 * (1 + 0.15 * coarse)
    crown = site.dtm[int(row), int(column)] + height * (
        0.45 + 0.55 * np.maximum(0, 1 - q) ** round_
    )
    crown += 0.25 * coarse + 0.08 * fine
    free = site.kind[window] != BUILDING
    on = (q < 1) & free & (crown > np.maximum(site.dsm[window], site.dtm[window] + 0.5))
    site.dsm[window][on] = crown[on]
    site.kind[window][on] = TREE
    site.grey[window][on] = tone + 11 * fine[on] + 6 * coarse[on]
    return True
