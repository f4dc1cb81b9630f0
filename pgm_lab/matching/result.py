"""The result of matching two photos, and the words that say what became of a point."""

import os
from dataclasses import dataclass

import numpy as np

from pgm_lab import _validate
from pgm_lab.io import files as _files
from pgm_lab.io import text as _numbers

COLUMNS = (
    *("point", "left column", "left row", "right column", "right row"),
    *("variance column", "covariance", "variance row", "r", "quality", "status"),
)

# What `ncc`, `lsm`, `matching` and `registration` say of a point, and what helps
STATUSES = {
    "accepted": ("found", ""),
    "template leaves the image": (
        "the template reaches beyond the left photo",
        "take a point farther inside, or a smaller template",
    ),
    "window leaves the image": (
        "what is sought lies beyond the right photo, or too near to its edge",
        "improve the start; perhaps the right photo does not show the point",
    ),
    "no data in the template": (
        "the template touches pixels that are masked, NaN or infinite",
        "take another point, or a smaller template",
    ),
    "no data in the window": (
        "all that is searched in the right photo touches pixels without data",
        "take another point, or a smaller template",
    ),
    "flat template": ("all grey values are the same", "take a point with texture"),
    "flat window": (
        "all grey values of the right window are the same, as where it is saturated",
        "take another point, or a photo that is less exposed",
    ),
    "position not determined": (
        "all lines run one way: the position along them could be any",
        "take a corner, or a larger template",
    ),
    "peak on the edge of the image": (
        "the best place touches the edge of the right photo, or pixels without data",
        "take another point",
    ),
    "peak on the border of the search": (
        "the best place lies at the border of what was searched",
        "enlarge the search, or improve the start",
    ),
    "below threshold": (
        "nothing that was found is alike enough",
        "improve the start; perhaps the right photo does not show the point",
    ),
    "changed": (
        "textured in both photos, but matched by nothing that was searched: r is far"
        " below what the neighbours reach",
        "perhaps a field was ploughed, or a cloud hides it: leave it out",
    ),
    "ambiguous": (
        "a second place is almost as much alike",
        "take a larger template, or search less, along the epipolar line",
    ),
    "another point from the right": (
        "sought from the right, another point of the left photo is the best",
        "perhaps only one of the photos sees the point",
    ),
    "parts disagree": (
        "small windows inside the template fit better elsewhere, as at a depth edge",
        "take a smaller template, or another point",
    ),
    "diverged": (
        "the window moved too far from its start, or took an impossible shape",
        "improve the start, or give its shape",
    ),
    "not precise enough": (
        "the predicted standard deviation is larger than was allowed",
        "take a point with more texture, or a larger template",
    ),
    "too many iterations": (
        "the window had not come to rest after the last iteration",
        "take a larger template, or give its shape",
    ),
}


@dataclass(frozen=True, eq=False)
class Match:
    """Result of `match` for n points.

    Attributes
    ----------
    chosen : ndarray (n, 2)
        Points in the left photo, (column, row) in pixels: as given, or as picked.
    points : ndarray (n, 2)
        Points in the right photo; NaN unless accepted.
    covariance : ndarray (n, 2, 2)
        Their covariance in square pixels; NaN unless accepted.
    shape : ndarray (n, 2, 2)
        ((a1, a2), (b1, b2)): how the window is turned, scaled and sheared from left to
        right; NaN unless accepted.
    r : ndarray (n,)
        Correlation coefficient of the two windows; NaN where nothing was compared.
    quality : ndarray (n,)
        Between 0 and 1, see `match`; NaN unless accepted, or "parts disagree".
    status : ndarray (n,) of str
        "accepted", or what went wrong first: the words of `STATUSES`.
    left_size, right_size : (int, int)
        Columns and rows of the photos in pixels.
    """

    chosen: np.ndarray
    points: np.ndarray
    covariance: np.ndarray
    shape: np.ndarray
    r: np.ndarray
    quality: np.ndarray
    status: np.ndarray
    left_size: tuple[int, int]
    right_size: tuple[int, int]

    @property
    def accepted(self) -> np.ndarray:
        """Whether the status is "accepted": ndarray (n,) of bool."""
        return self.status == "accepted"

    @property
    def sd(self) -> np.ndarray:
        """Standard deviation of a coordinate in pixels: ndarray (n,).

        The root of the mean variance of column and row; NaN unless accepted.
        """
        return np.sqrt(np.trace(self.covariance, axis1=1, axis2=2) / 2)

    def save(self, path: str | os.PathLike, *, overwrite: bool = False) -> None:
        """Save all points as a table, with what became of each.

        For the bundle, `observations.from_matches` turns matches into observations,
        which can be saved too.

        Parameters
        ----------
        path : str or path
            A file of comma-separated values (CSV): the number of the point from 0, its
            positions in pixels, the covariance of the right one in square pixels, r,
            quality and status. What a point has not is left empty.
        overwrite : bool
            Whether a file of this name may be replaced.

        Raises
        ------
        FileExistsError
            If the file is there already.
        OSError
            If it cannot be written; an old one stays.

        Examples
        --------
        >>> from tempfile import TemporaryDirectory
        >>> from pgm_lab import matching, simulate
        >>> pair = simulate.texture_pair(
        ...     simulate.texture(seed=1), (120, 160), (3.5, 1, 0, -2.25, 0, 1)
        ... )
        >>> found = matching.match(*pair, [(60, 50), (4, 4)], start=[(64, 48), (7, 2)])
        >>> with TemporaryDirectory() as folder:
        ...     found.save(f"{folder}/found.csv")
        ...     with open(f"{folder}/found.csv") as file:
        ...         print(file.read().splitlines()[-1])
        1,4.0,4.0,,,,,,,,template leaves the image
        """
        overwrite = _validate.flag(overwrite, "overwrite")
        _files.save({_files.place(path): self.csv()}, overwrite=overwrite)

    def csv(self) -> str:
        """Return the table that `save` writes."""
        C = self.covariance
        numbers = np.column_stack(
            [self.chosen, self.points, C[:, 0, 0], C[:, 0, 1], C[:, 1, 1], self.r,
             self.quality]
        )  # fmt: skip
        return _numbers.written(COLUMNS, numbers, self.status)
