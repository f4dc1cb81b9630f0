"""Matches become image observations: photo coordinates with their covariances.

The step from chapters 2 and 3 to chapters 5 and 6: one call converts the results of
`ncc.match`, `lsm.match` and `matching.match` into the rows that `bundle.Network.of`
takes, or into a file that `bundle.read` takes; `read` reads it back.
"""

import os
from collections import Counter
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate, frames, lsm, matching, ncc
from pgm_lab.bundle.files import read_sigma, whole_numbers
from pgm_lab.bundle.network import RAY
from pgm_lab.io import files, text

Match = ncc.Match | lsm.Match | matching.Match
NO_SIGMA = "Without sx and sy their precision is unknown"


@dataclass(frozen=True, eq=False)
class Observations:
    """Image coordinates of points in photos, all by their names.

    Attributes
    ----------
    photo, point : tuple (k,)
        Names of the photo and of the point of each ray.
    xy : ndarray (k, 2)
        Photo coordinates in mm.
    covariance : ndarray (k, 2, 2)
        Their covariances in mm^2.
    dropped : dict {(photo, status): number}
        Number of matches left out in a photo, by the status that gives the reason.
    """

    photo: tuple[Hashable, ...]
    point: tuple[Hashable, ...]
    xy: np.ndarray
    covariance: np.ndarray
    dropped: dict[tuple[Hashable, str], int]

    @property
    def rows(self) -> list[tuple]:
        """Rows (photo, point, x, y, covariance), as `bundle.Network.of` takes them."""
        return list(zip(self.photo, self.point, *self.xy.T, self.covariance))

    def common(self, *photos: Hashable) -> tuple[tuple[Hashable, ...], np.ndarray]:
        """Points that all of these photos show.

        Parameters
        ----------
        *photos : names of photos

        Returns
        -------
        names : tuple (n,)
            In the order of the first photo.
        xy : ndarray (photos, n, 2)
            Their photo coordinates in mm.
        """
        where: list[dict[Hashable, int]] = [{} for _ in photos]
        for photo, rows in zip(photos, where):
            if photo not in self.photo:
                raise ValueError(f"no observation was made in photo {photo!r}")
            rows |= {self.point[i]: i for i, p in enumerate(self.photo) if p == photo}
        names = tuple(p for p in where[0] if all(p in rows for rows in where))
        return names, self.xy[[[rows[p] for p in names] for rows in where]]

    def save(self, path: str | os.PathLike, *, overwrite: bool = False) -> None:
        """Save the observations as the table of image coordinates of `bundle.read`.

        Parameters
        ----------
        path : str or path
            CSV: point, photo, x, y, sx, sy in mm, without the correlation of x and y.
        overwrite : bool
            Whether a file of this name may be replaced.

        Raises
        ------
        ValueError
            If names of photos or points are not whole numbers.
        FileExistsError
            If the file exists already.
        OSError
            If it cannot be written; an old one stays.
        """
        files.save({path: self.csv()}, overwrite=overwrite)

    def csv(self) -> str:
        """Return the table that `save` writes."""
        points = whole_numbers(self.point, "names of points")
        photos = whole_numbers(self.photo, "names of photos")
        sigma = np.sqrt(self.covariance[:, [0, 1], [0, 1]])
        rows = zip(points, photos, *self.xy.T.tolist(), *sigma.T.tolist())
        # repr has the fewest digits that read back as the same number
        lines = [",".join(map(repr, row)) for row in rows]
        return "\n".join([f"% {', '.join(RAY)}; mm", *lines, ""])

    def __str__(self) -> str:
        """Number of points of each photo, and what was dropped and why."""
        lines = []
        for photo, number in Counter(self.photo).items():
            why = [f"{n} {s}" for (p, s), n in self.dropped.items() if p == photo]
            dropped = f", dropped: {', '.join(why)}" if why else ""
            lines.append(f"photo {photo}: {number} points{dropped}")
        return "\n".join(lines)


def read(path: str | os.PathLike) -> Observations:
    """Read the file that `Observations.save` and `stereo_map.save` write.

    Parameters
    ----------
    path : str or path
        Point, photo, x, y, sx, sy in mm, as for `bundle.read`.

    Returns
    -------
    Observations
        With whole numbers as names, and no correlation between x and y.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        If the file is wrong: its name, the number of the line, and the reason.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder) / "points.csv"
    ...     _ = path.write_text("7, 1, 5.0, 1.0, 0.002, 0.003")
    ...     read(path).rows[0][:4]
    (1, 7, np.float64(5.0), np.float64(1.0))
    """
    table = text.read_table(path, "image coordinates", RAY, 2, NO_SIGMA)
    point, photo = table.ids(0, "point"), table.ids(1, "photo")
    sigma = read_sigma(table)
    C = np.zeros((len(sigma), 2, 2))
    C[:, [0, 1], [0, 1]] = sigma**2
    names = tuple(photo.tolist()), tuple(point.tolist())
    return Observations(*names, table.values[:, 2:4], C, {})


def from_matches(
    left_points: ArrayLike,
    matches: Mapping[Hashable, Match],
    image_size: ArrayLike,
    pixel_size: ArrayLike,
    *,
    left: Hashable,
    points: Sequence[Hashable] | None = None,
) -> Observations:
    """Convert matches of one photo with others into image observations.

    Only accepted matches count; a point without any is left out in the left photo too.

    Parameters
    ----------
    left_points : array_like (n, 2)
        The matched points, (column, row) in pixels.
    matches : mapping {name of the right photo: Match}
        Results of `ncc.match`, `lsm.match` or `matching.match`, each of the same n
        points.
    image_size : (columns, rows)
        Of all photos, in pixels.
    pixel_size : float or (x, y)
        In mm.
    left : name
        Of the left photo.
    points : sequence of n names, optional
        Default: 0, 1, ...

    Returns
    -------
    Observations

    Raises
    ------
    ValueError
        If a match does not have n points, none is accepted, or names are not unique.

    Notes
    -----
    Matching puts all noise into the right photo. But a part came from the left window,
    and moves the matches in all other photos in the same way. Counted as an error e_0
    of the left point, with e_i from the right window, the match scatters by e_i - J
    e_0, and

        C = C_i + J C_0 J^T,    C_i = C / 2 = J C_0 J^T

    with J, the affine shape that least squares matching found (the identity for `ncc`),
    for equal noise and contrast; C_0 is the mean over the photos. All observations are
    then independent. The measured point is offset from the chosen one by e_0, on the
    same surface.

    Examples
    --------
    >>> from pgm_lab import simulate
    >>> grey = simulate.texture_pair(
    ...     simulate.texture(seed=1), (60, 80), (3.25, 1, 0, -1.5, 0, 1), sigma=1.0
    ... )
    >>> chosen = [(30, 28), (40, 30), (3, 3)]
    >>> start = ncc.match(*grey, chosen, search=41)
    >>> fine = lsm.match(*grey, chosen, np.nan_to_num(start.points))
    >>> found = from_matches(chosen, {"B": fine}, (80, 60), 0.01, left="A")
    >>> print(found)
    photo A: 2 points
    photo B: 2 points, dropped: 1 template leaves the image
    >>> found.rows[2][:2], found.xy[2].round(3)
    (('B', 0), array([-0.063,  0.03 ]))
    """
    chosen = _validate.point_list(left_points, "left_points")
    n = len(chosen)
    names = (*range(n),) if points is None else (*_validate.several(points, "points"),)
    if len(names) != n or len(set(names)) != n:
        raise ValueError(f"points must be {n} different names; got {len(names)}")
    if left in matches:
        raise ValueError(f"photo {left!r} is the left one: it cannot match itself")
    of_left, count = np.zeros((n, 2, 2)), np.zeros(n, int)
    photos, rays, pixels, covariances = [], [], [], []
    dropped: dict[tuple[Hashable, str], int] = {}
    for photo, match in matches.items():
        if len(match.status) != n:
            raise ValueError(
                f"the match with photo {photo!r} has {len(match.status)} points, but"
                f" left_points has {n}"
            )
        if isinstance(match, matching.Match):
            _refuse_others(match, photo, chosen, image_size)
        good = np.flatnonzero(match.accepted)
        lost = Counter(match.status[~match.accepted].tolist())
        dropped |= {(photo, status): number for status, number in lost.items()}
        photos += [photo] * len(good)
        rays.append(good)
        pixels.append(match.points[good])
        covariances.append(match.covariance[good] / 2)
        of_left[good] += _in_left_photo(match, good) / 2
        count[good] += 1
    good = np.flatnonzero(count)
    if not len(good):
        raise ValueError(f"no match was accepted: {dropped}")
    C = np.concatenate([of_left[good] / count[good, None, None], *covariances])
    xy, C = frames.pixel_to_photo(
        np.concatenate([chosen[good], *pixels]), image_size, pixel_size, covariance=C
    )
    point = tuple(names[i] for i in np.concatenate([good, *rays]))
    return Observations((*[left] * len(good), *photos), point, xy, C, dropped)


def _in_left_photo(match: Match, good: np.ndarray) -> np.ndarray:
    """Covariances (m, 2, 2) of matches, converted into pixels of the left photo."""
    C = match.covariance[good]
    if isinstance(match, ncc.Match):
        return C
    if isinstance(match, matching.Match):
        shape = match.shape[good]
    else:
        shape = match.parameters[good][:, [[1, 2], [4, 5]]]
    J = np.linalg.inv(shape)
    return J @ C @ np.swapaxes(J, 1, 2)


def _refuse_others(
    match: matching.Match, photo: Hashable, chosen: np.ndarray, image_size: ArrayLike
) -> None:
    """Refuse a match of other points, or of photos of another size."""
    if not np.array_equal(match.chosen, chosen):
        raise ValueError(
            f"the match with photo {photo!r} has other points than left_points: give"
            " the same points to each match"
        )
    size = tuple(_validate.image_size(image_size).astype(int).tolist())
    for side in (match.left_size, match.right_size):
        if side != size:
            raise ValueError(
                f"photo {photo!r} was matched with photos of {match.left_size} and"
                f" {match.right_size} (columns, rows), but image_size is {size}: all"
                " photos must have the same size"
            )
