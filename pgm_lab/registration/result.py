"""The shifts of chips between two images, and what they say together."""

import os
from collections import Counter
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pgm_lab import _files, _numbers, _validate
from pgm_lab._statuses import STATUSES
from pgm_lab.registration.accuracy import Accuracy, accuracy

COLUMNS = (
    *("chip", "column in the reference (px)", "row in the reference (px)"),
    "shift of the column (px; sensed minus reference)",
    "shift of the row (px; sensed minus reference; down is positive)",
    *("r at the highest peak", "r at the second peak (-1: none)"),
    *("variance of the column (px2)", "covariance (px2)", "variance of the row (px2)"),
    "status",
)


@dataclass(frozen=True, eq=False)
class Registration:
    """Where n chips of the reference image lie in the sensed one.

    Attributes
    ----------
    points : ndarray (n, 2)
        (column, row) in the reference image, in pixels, as given.
    dx, dy : ndarray (n,)
        Shift in pixels, sensed minus reference, beyond the offset that was given: dx to
        the right, dy down. Of the highest peak, also where the status warns of it; NaN
        where nothing was compared.
    r : ndarray (n,)
        Pearson's correlation coefficient at the highest whole pixel; NaN where nothing
        was compared.
    second : ndarray (n,)
        At the second highest peak; -1 where there is no other, NaN as for r.
    covariance : ndarray (n, 2, 2)
        Of (dx, dy) as predicted, in square pixels; NaN unless accepted.
    status : ndarray (n,) of str
        "accepted", or what went wrong first: the words of `matching.STATUSES`.
    """

    points: np.ndarray
    dx: np.ndarray
    dy: np.ndarray
    r: np.ndarray
    second: np.ndarray
    covariance: np.ndarray
    status: np.ndarray

    @property
    def accepted(self) -> np.ndarray:
        """Whether the status is "accepted": ndarray (n,) of bool."""
        return self.status == "accepted"

    @property
    def sd(self) -> np.ndarray:
        """Predicted standard deviation of a coordinate in pixels: ndarray (n,).

        The root of the mean variance of dx and dy; NaN unless accepted.
        """
        return np.sqrt(np.trace(self.covariance, axis1=1, axis2=2) / 2)

    @cached_property
    def accuracy(self) -> Accuracy:
        """Means, root mean squares and quantiles of the accepted shifts, in pixels.

        Raises
        ------
        ValueError
            If no chip is accepted: then the images do not say how they lie.
        """
        if not self.accepted.any():
            raise ValueError(self._nothing())
        return accuracy(self.dx[self.accepted], self.dy[self.accepted])

    @property
    def rmse_x(self) -> float:
        """Of the accepted shifts, in pixels (Br 2)."""
        return self.accuracy.rmse_x

    @property
    def rmse_y(self) -> float:
        """Of the accepted shifts, in pixels (Br 3)."""
        return self.accuracy.rmse_y

    @property
    def rmse_t(self) -> float:
        """Of the accepted shifts, in pixels (Br 4)."""
        return self.accuracy.rmse_t

    @property
    def ce90(self) -> float:
        """Length that nine tenths of the accepted shifts do not exceed, in pixels."""
        return self.accuracy.ce90

    def _nothing(self) -> str:
        """What to do when nothing is accepted."""
        if not len(self.status):
            return "there are no chips, and so no shift. Give points"
        found = Counter(map(str, self.status)).most_common()
        counts = ", ".join(f"{number} {status}" for status, number in found)
        meaning, help = STATUSES[found[0][0]]
        return (
            f"none of {len(self.status)} chips is accepted, and the images do not say"
            f" how they lie: {counts}. Of most {meaning}: {help}. If the images show"
            " the same ground, their shift may be larger than the radius"
        )

    def save(self, path: str | os.PathLike, *, overwrite: bool = False) -> None:
        """Save all chips as a table, with what became of each.

        Parameters
        ----------
        path : str or path
            A file of comma-separated values (CSV), whose first line names its columns
            with their units. Chips are numbered from 0. What a chip has not is left
            empty.
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
        >>> from pgm_lab import registration
        >>> reference = np.random.default_rng(1).integers(0, 256, (100, 100))
        >>> sensed = np.roll(reference, (2, -1), axis=(0, 1))
        >>> found = registration.register(reference, sensed, [(50, 50), (5, 50)])
        >>> with TemporaryDirectory() as folder:
        ...     found.save(f"{folder}/shifts.csv")
        ...     with open(f"{folder}/shifts.csv") as file:
        ...         print(file.read().splitlines()[-1])
        1,5.0,50.0,,,,,,,,template leaves the image
        """
        overwrite = _validate.flag(overwrite, "overwrite")
        _files.save({_files.place(path): self.csv()}, overwrite=overwrite)

    def csv(self) -> str:
        """Return the table that `save` writes."""
        C = self.covariance
        numbers = np.column_stack(
            [self.points, self.dx, self.dy, self.r, self.second, C[:, 0, 0],
             C[:, 0, 1], C[:, 1, 1]]
        )  # fmt: skip
        return _numbers.written(COLUMNS, numbers, self.status)
