"""The statuses of matching: what became of each point.

One vocabulary for `ncc`, `lsm`, `matching`, `registration` and `stereo`.
"""

import os

import numpy as np

from pgm_lab.io import files


class Matched:
    """What the results of `ncc`, `lsm`, `matching` and `registration` share."""

    covariance: np.ndarray
    status: np.ndarray

    @property
    def accepted(self) -> np.ndarray:
        """Whether the status is "accepted": ndarray (n,) of bool."""
        return self.status == "accepted"

    @property
    def sd(self) -> np.ndarray:
        """Root (n,) of the mean variance of column and row, px; NaN unless accepted."""
        return np.sqrt(np.trace(self.covariance, axis1=1, axis2=2) / 2)


class Table(Matched):
    """What the results of `matching` and `registration` share beyond that."""

    def csv(self) -> str:
        """Return the table that `save` writes."""
        raise NotImplementedError

    def save(self, path: str | os.PathLike, *, overwrite: bool = False) -> None:
        """Save all points as a table, with the status of each.

        Parameters
        ----------
        path : str or path
            A file of comma-separated values (CSV); its first line names columns and
            units. Missing values are empty. For the bundle, `observations.from_matches`
            converts matches into observations, which can be saved too.
        overwrite : bool
            Whether a file of this name may be replaced.

        Raises
        ------
        OSError
            If the file exists already, or cannot be written; an old one stays.

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
        files.save({path: self.csv()}, overwrite=overwrite)


# Status: what it means, what helps
STATUSES = {
    "accepted": ("found", ""),
    "template leaves the image": (
        "the template reaches beyond the left photo",
        "take a point farther inside, or a smaller template",
    ),
    "window leaves the image": (
        "the search lies beyond the right photo, or too near to its edge",
        "improve the start; perhaps the right photo does not show the point",
    ),
    "no data in the template": (
        "the template touches pixels that are masked, NaN or infinite",
        "take another point, or a smaller template",
    ),
    "no data in the window": (
        "every position searched in the right photo touches pixels without data",
        "take another point, or a smaller template",
    ),
    "flat template": ("all grey values are the same", "take a point with texture"),
    "flat window": (
        "all grey values of the right window are the same, as where it is saturated",
        "take another point, or a photo that is less exposed",
    ),
    "position not determined": (
        "all edges are parallel: the position along them is undetermined",
        "take a corner, or a larger template",
    ),
    "peak on the edge of the image": (
        "the best position touches the edge of the photo, or pixels without data",
        "take another point",
    ),
    "peak on the border of the search": (
        "the best position lies on the border of the search",
        "enlarge the search, or improve the start",
    ),
    "below threshold": (
        "no position is similar enough",
        "improve the start; perhaps the right photo does not show the point",
    ),
    "changed": (
        "textured in both photos, but similar to nothing that was searched: r is far"
        " below what the neighbours reach",
        "perhaps a field was ploughed, or a cloud hides it: leave it out",
    ),
    "ambiguous": (
        "a second position is almost as similar",
        "take a larger template, or search less, along the epipolar line",
    ),
    "left-right check failed": (
        "searched from the right, another point of the left photo fits best",
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
    "not converged": (
        "least squares matching had not converged after the last iteration",
        "take a larger template, or give its shape",
    ),
    "isolated": (
        "part of a small patch whose disparities differ from those around it",
        "enlarge the window, or leave it out",
    ),
}
