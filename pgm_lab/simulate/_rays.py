"""Where rays from above first meet a surface of heights."""

import numpy as np

BLOCKS = (32, 8, 2)  # cells: rays go down by blocks as long as they are above all
STEEP = 0.6  # m, the step down for each cell of rays that hardly move sideways
CLOSE = 1e-4  # m between a ray and the surface where they meet
ROUNDS = 60  # a halving every third round brings a metre far below CLOSE


def bilinear(layer: np.ndarray, row: np.ndarray, column: np.ndarray) -> np.ndarray:
    """Values at (row, column) of cells, without rounding them; the edge goes on."""
    rows, columns = layer.shape
    row = np.clip(row, 0, rows - 1)
    column = np.clip(column, 0, columns - 1)
    r = np.minimum(row.astype(np.intp), max(rows - 2, 0))
    c = np.minimum(column.astype(np.intp), max(columns - 2, 0))
    down, right = row - r, column - c
    first = r * columns + c
    flat = layer.ravel()
    below = first + columns * (rows > 1)
    beside = int(columns > 1)
    upper = flat[first] * (1 - right) + flat[first + beside] * right
    lower = flat[below] * (1 - right) + flat[below + beside] * right
    return upper * (1 - down) + lower * down


class Surface:
    """Heights in cells, with the greatest height of blocks of cells.

    Parameters
    ----------
    z : ndarray (rows, columns)
        Heights in m.

    Attributes
    ----------
    tops : list of (block, ndarray)
        A block, with the greatest height in it and in the blocks around.
    """

    def __init__(self, z: np.ndarray) -> None:
        self.z = z
        self.tops = [(block, _tops(z, block)) for block in BLOCKS]

    def meet(
        self,
        row: np.ndarray,
        down: np.ndarray,
        column: np.ndarray,
        right: np.ndarray,
    ) -> np.ndarray:
        """Heights (n,) where rays that come from above first meet the surface.

        Parameters
        ----------
        row, column : ndarray (n,)
            Where the rays are at height 0, in cells.
        down, right : ndarray (n,)
            Cells that they move for each metre of height.

        Notes
        -----
        A ray goes down in steps of at most a block sideways while it stays above the
        tops of the blocks around, then with smaller blocks, and at last by half a cell,
        so that no more than the corner of a cell is missed. The step that ends below
        the surface is closed in on.
        """
        z = np.full(row.shape, float(self.z.max()) + 0.1)
        level = 1 / np.maximum(np.maximum(np.abs(down), np.abs(right)), 1 / STEEP)
        for block, top in self.tops:
            step = block * level
            go = np.arange(z.size)
            while go.size:
                low = z[go] - step[go]
                middle = low + step[go] / 2
                r = (row[go] + middle * down[go]).astype(np.int32) // block
                c = (column[go] + middle * right[go]).astype(np.int32) // block
                r = np.clip(r, 0, top.shape[0] - 1)
                c = np.clip(c, 0, top.shape[1] - 1)
                free = top[r, c] < low
                go = go[free]
                z[go] = low[free]
        return self._close(row, down, column, right, z, level / 2)

    def _close(
        self,
        row: np.ndarray,
        down: np.ndarray,
        column: np.ndarray,
        right: np.ndarray,
        high: np.ndarray,
        step: np.ndarray,
    ) -> np.ndarray:
        """From above the surface down to it, by steps and then between the last two.

        Rays that are still on their way stand together in the arrays `high` (heights
        above the surface, by `over`), `low` (below it, by `under`).
        """
        z = np.empty_like(high)
        rays = row, down, column, right
        low, over, under = z.copy(), self._above(high, *rays), z.copy()
        go = np.arange(high.size)
        while go.size:
            low[go] = high[go] - step[go]
            under[go] = self._above(low[go], *(ray[go] for ray in rays))
            go = go[under[go] > 0]
            high[go], over[go] = low[go], under[go]
        go = np.arange(high.size)
        for k in range(ROUNDS):
            share = 0.5 if k % 3 == 2 else over / (over - under)
            middle = high + share * (low - high)
            d = self._above(middle, *rays)
            z[go] = middle
            far = np.abs(d) > CLOSE
            if not far.any():
                break
            up = d > 0
            high, over = np.where(up, middle, high)[far], np.where(up, d, over)[far]
            low, under = np.where(up, low, middle)[far], np.where(up, under, d)[far]
            go, rays = go[far], tuple(ray[far] for ray in rays)
        return z

    def _above(
        self,
        z: np.ndarray,
        row: np.ndarray,
        down: np.ndarray,
        column: np.ndarray,
        right: np.ndarray,
    ) -> np.ndarray:
        """How far rays are above the surface where they have the height z."""
        return z - bilinear(self.z, row + z * down, column + z * right)


def _tops(z: np.ndarray, block: int) -> np.ndarray:
    """Greatest height in each block and in its neighbours."""
    rows, columns = (-(-n // block) for n in z.shape)
    full = np.full((rows * block, columns * block), -np.inf, np.float32)
    full[: z.shape[0], : z.shape[1]] = z
    top = full.reshape(rows, block, columns, block).max((1, 3))
    around = np.pad(top, 1, constant_values=-np.inf)
    wide = np.maximum(np.maximum(around[:-2], around[1:-1]), around[2:])
    return np.maximum(np.maximum(wide[:, :-2], wide[:, 1:-1]), wide[:, 2:])
