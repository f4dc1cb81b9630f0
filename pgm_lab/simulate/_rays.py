"""Where rays from above first meet a surface of heights."""

import numpy as np

BLOCKS = (32, 8, 2)  # cells: rays go down by blocks as long as they are above all
LONGEST = 5.0  # m, a step down of rays that hardly move sideways
CLOSE = 1e-4  # m between a ray and the surface where they meet
ROUNDS = 60  # a halving every second round brings 5 m to less than CLOSE


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
        start: float,
    ) -> np.ndarray:
        """Heights (n,) where rays that come from above first meet the surface.

        Parameters
        ----------
        row, column : ndarray (n,)
            Where the rays are at height 0, in cells.
        down, right : ndarray (n,)
            Cells that they move for each metre of height.
        start : float
            Height to start from, above the surface.

        Notes
        -----
        A ray goes down in steps of at most a block sideways while it stays above the
        tops of the blocks around, with smaller blocks, and at last by a cell. The step
        that ends below the surface is closed in on by turns of the false position and
        halving.
        """
        z = np.full(row.shape, float(start))
        sideways = np.maximum(np.abs(down), np.abs(right))
        for block, top in self.tops:
            step = np.minimum(LONGEST, block / np.maximum(sideways, 1e-9))
            go = np.arange(z.size)
            while go.size:
                low = z[go] - step[go]
                middle = z[go] - step[go] / 2
                r = (row[go] + middle * down[go]) // block
                c = (column[go] + middle * right[go]) // block
                r = np.clip(r, 0, top.shape[0] - 1).astype(np.intp)
                c = np.clip(c, 0, top.shape[1] - 1).astype(np.intp)
                free = top[r, c] < low
                go = go[free]
                z[go] = low[free]
        return self._close(row, down, column, right, z, np.minimum(LONGEST / 4, step))

    def _close(self, row, down, column, right, z, step):  # type: ignore[no-untyped-def]
        step = step / BLOCKS[-1]
        go = np.arange(z.size)

        def above(height: np.ndarray) -> np.ndarray:
            r, c = row[go] + height * down[go], column[go] + height * right[go]
            return height - bilinear(self.z, r, c)

        high, low = z.copy(), z.copy()
        over = np.empty_like(z)
        over[:] = above(z)
        under = over.copy()
        while go.size:  # down by a cell
            low[go] = high[go] - step[go]
            under[go] = above(low[go])
            go = go[under[go] > 0]
            high[go], over[go] = low[go], under[go]
        go = np.arange(z.size)
        for k in range(ROUNDS):
            a, b = over[go], under[go]
            share = 0.5 if k % 3 == 2 else np.clip(a / np.maximum(a - b, 1e-12), 0, 1)
            z[go] = high[go] + share * (low[go] - high[go])
            d = above(z[go])
            up = d > 0
            high[go[up]], over[go[up]] = z[go[up]], d[up]
            low[go[~up]], under[go[~up]] = z[go[~up]], d[~up]
            go = go[np.abs(d) > CLOSE]
            if not go.size:
                break
        return z


def _tops(z: np.ndarray, block: int) -> np.ndarray:
    """Greatest height in each block and in its neighbours."""
    rows, columns = (-(-n // block) for n in z.shape)
    full = np.full((rows * block, columns * block), -np.inf, np.float32)
    full[: z.shape[0], : z.shape[1]] = z
    top = full.reshape(rows, block, columns, block).max((1, 3))
    around = np.pad(top, 1, constant_values=-np.inf)
    wide = np.maximum(np.maximum(around[:-2], around[1:-1]), around[2:])
    return np.maximum(np.maximum(wide[:, :-2], wide[:, 1:-1]), wide[:, 2:])
