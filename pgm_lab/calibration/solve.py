"""Calibrate a camera by photos of a board whose points are unknowns, too.

The board gives start values and, by its scale bars, the unit of length; its shape comes
out of the photos. A corner's covariance says how well the grey values show it, but not
what else went wrong in its photo: motion, a rolling shutter, a board that bends. So
each photo has a variance component of its own, q^2, which is added to the covariances
of its corners, and estimated from their residuals (Foerstner 1979).
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import cv2
import numpy as np
import scipy
from numpy.typing import ArrayLike

from pgm_lab import _validate, bundle, frames, rotation
from pgm_lab.adjustment.result import UNCONTROLLED
from pgm_lab.calibration.board import Board
from pgm_lab.calibration.measure import Measured
from pgm_lab.camera import PARAMETERS, Camera, ideal, imaging

SQUARE = ("c", "x0", "y0", "K1", "K2", "K3", "P1", "P2")  # pixels without b1 and b2
MIN_CORNERS = 12  # in a photo
MIN_PHOTOS = 4
MIN_TILT = np.radians(10.0)  # between two photos: all parallel, c is not determined
COMPONENT_STEPS = 3
FIRST_COMPONENT = 0.1  # px
LEAST_COMPONENT = 1e-3  # of the variance by the noise
MOST_REMOVED = 30
MEDIAN_CHI_SQUARE = scipy.special.chdtri(1, 0.5)
HALVES = 5  # ways to part the photos
SURE = 0.99
# What must be the same in all photos
SAME = (
    ("number of columns and rows", lambda one: one.image_size),
    ("camera, as EXIF states it,", lambda one: one.model),
    ("focal length (mm)", lambda one: (one.focal,)),
)
OTHER_CAMERA = (
    "Photos of another camera or zoom, screenshots, and photos that a program turned or"
    " cut after they were taken, have no place in one calibration"
)
TO_OPENCV = np.diag([1.0, -1.0, -1.0])  # y down and z away, in camera and board


@dataclass(frozen=True, eq=False)
class Calibration:
    """A camera with its covariance, and the network it came from.

    Attributes
    ----------
    board : Board
    photos : tuple of Measured
        Those in the network, in its order.
    left_out : dict {name: str}
        Why a photo is not in it.
    image_size : (columns, rows)
    pixel_size : float
        In mm.
    result : bundle.Bundle
        Camera, exterior orientations, and the board's points in mm, which are named by
        their number on the board.
    removed : tuple of bundle.Blunder
        Corners that data snooping rejected.
    component : ndarray (m,)
        Standard deviation q of what a photo adds to the errors of its corners, in px.
    halves : ndarray (h, 2)
        Of the camera and of the board, in halves of the photos: their root mean square
        difference over the predicted standard deviation, which should be 1.
    """

    board: Board
    photos: tuple[Measured, ...]
    left_out: dict[str, str]
    image_size: tuple[int, int]
    pixel_size: float
    result: bundle.Bundle
    removed: tuple[bundle.Blunder, ...]
    component: np.ndarray
    halves: np.ndarray

    @property
    def factor(self) -> np.ndarray:
        """By how much the sd of the camera and of the board are to be multiplied (2,).

        1 unless the halves of the photos differ more than chance explains.
        """
        if not len(self.halves):
            return np.ones(2)
        factor = np.sqrt(np.mean(self.halves**2, axis=0))
        dof = len(self.halves) * len(self.result.estimate)
        by_chance = np.sqrt(scipy.special.chdtri(dof, 1 - SURE) / dof)
        return np.where(factor > by_chance, factor, 1.0)

    @property
    def _scale(self) -> np.ndarray:
        """The factors, over sigma0 if that is below 1: no photo beats its noise."""
        return self.factor / min(self.result.sigma0, 1.0)

    @property
    def covariance(self) -> np.ndarray:
        """Covariance (u, u) of the interior parameters, with the factor."""
        return self._scale[0] ** 2 * self.result.covariance_interior

    @property
    def sd_shape(self) -> np.ndarray:
        """Standard deviations (n, 3) of the board's points in mm, with the factor."""
        return self._scale[1] * self.result.sd_points

    @property
    def camera(self) -> Camera:
        """The calibrated camera."""
        return self.result.cameras[0]

    @property
    def printed(self) -> np.ndarray:
        """Where the board's points (n, 3) were printed, in mm."""
        return self.board.points[list(self.result.network.point_names)]

    @property
    def shape(self) -> np.ndarray:
        """How far the board's points (n, 3) lie from there, in mm."""
        return self.result.points - self.printed

    @cached_property
    def flat(self) -> bundle.Bundle:
        """The same observations if the board is taken for flat and exactly printed."""
        fixed = np.arange(len(self.printed))
        bars = np.zeros((0, 4))
        held = replace(
            self.result.network, points=self.printed, fixed=fixed, scale_bars=bars
        )
        return bundle.adjust(held, self.result.estimate)

    def ray_derivatives(self, pixels: ArrayLike) -> np.ndarray:
        """How the image of the rays of pixels (n, 2) moves (n, 2, u), in pixels.

        By the interior parameters that were estimated, when the camera turns with each
        as far as it has to: an orientation of a photo finds that by itself.
        """
        # Over the whole image, the rotation that a change of each parameter calls for
        axes = (np.linspace(0, n - 1, 15) for n in self.image_size)
        J, A = self._derivatives(np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2))
        u = J.shape[-1]
        turn = np.linalg.lstsq(A.reshape(-1, 3), J.reshape(-1, u), rcond=None)[0]
        J, A = self._derivatives(_validate.points(pixels, 2, "pixels"))
        return (J - A @ turn) / self.pixel_size

    def _derivatives(self, pixels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of image points by the interior (n, 2, u) and by rotations."""
        camera, estimate = self.camera, self.result.estimate
        xy = frames.pixel_to_photo(pixels, self.image_size, self.pixel_size)
        x = np.column_stack([ideal(camera, xy), np.full(len(xy), -camera.c)])
        _, _, by = imaging.misclosure(
            camera.interior, np.zeros(6), x, xy, camera.lens, ("interior", "exterior")
        )
        columns = [PARAMETERS.index(name) for name in estimate]
        return by["interior"][..., columns], by["exterior"][..., 3:]

    def ray_sd(self, pixels: ArrayLike) -> np.ndarray:
        """Standard deviation (n,) in px of a coordinate, of the rays of pixels."""
        J = self.ray_derivatives(pixels)
        return np.sqrt(np.einsum("nip,pq,niq->n", J, self.covariance, J) / 2)


def calibrate(
    photos: Sequence[Measured],
    board: Board,
    *,
    pixel_size: float = 0.001,
    estimate: Sequence[str] | None = None,
    flat: bool = False,
) -> Calibration:
    """Calibrate a camera by its photos of a board.

    Parameters
    ----------
    photos : sequence of Measured
        Corners of each photo, as `measure` finds them.
    board : Board
        Its scale bars, if it has any, give the scale.
    pixel_size : float
        In mm. Where nobody knows it, any value serves: c is then right in pixels.
    estimate : sequence of str, optional
        Interior parameters, from `camera.PARAMETERS`. When missing all ten, but b1 and
        b2 only if they differ from 0 by more than chance.
    flat : bool
        Whether the board's points are held where they were printed.

    Returns
    -------
    Calibration

    Raises
    ------
    ValueError
        If too few photos are left, or all look the same way. What is wrong with a
        single photo is said in `left_out`.
    RankDefect
        If the photos do not determine all unknowns.

    Notes
    -----
    The lens is modelled forward, as in OpenCV. Covariances are those of the adjustment,
    with each corner's own covariance plus the component of its photo.

    References
    ----------
    Muliawan 2013, section II.10; Foerstner 1979 for the components; Baarda 1968 for
    the search for blunders.
    """
    _validate.instance(board, Board, "board")
    pixel_size = _validate.positive_number(pixel_size, "pixel_size", "mm")
    for name in estimate or ():
        _validate.choice(name, "estimate", PARAMETERS)
    good, left_out = chosen(photos)
    size = good[0].image_size

    # Start values: c by homographies, the stations by resection
    points = (board.points[one.ids] for one in good)
    c = start_c(points, (one.pixels for one in good), size)
    lens = Camera(c * pixel_size, lens="forward")
    exteriors = np.array(
        [_start_exterior(one, board, lens, pixel_size) for one in good]
    )
    _refuse_parallel(exteriors)
    network = _network(good, board, lens, exteriors, pixel_size, flat)

    # Adjust; without b1 and b2 where they say nothing
    noise = network.covariance
    assert noise is not None
    first = FIRST_COMPONENT * pixel_size
    network, removed, noise = _weighted(network, noise, first, estimate or PARAMETERS)
    result, q, halves = _solved(network, noise, estimate or PARAMETERS)
    parts = board, tuple(good), left_out, size, pixel_size
    found = Calibration(*parts, result, removed, q / pixel_size, halves)
    if estimate is None:
        b, C = result.interior[-2:], found.covariance[-2:, -2:]
        if b @ np.linalg.solve(C, b) < scipy.special.chdtri(2, 1 - SURE):
            square = replace(result.cameras[0], b1=0.0, b2=0.0)
            network = replace(_continued(result), cameras=(square,))
            result, q, halves = _solved(network, noise, SQUARE)
            found = Calibration(*parts, result, removed, q / pixel_size, halves)
    return found


def _weighted(
    network: bundle.Network, noise: np.ndarray, first: float, estimate: Sequence[str]
) -> tuple[bundle.Network, tuple[bundle.Blunder, ...], np.ndarray]:
    """Network with the components of its photos and without blunders, which follow.

    And the noise of the rays that stay.
    """
    # The component of each photo, robust while there may be blunders
    q = np.full(len(network.exteriors), first)
    for _ in range(COMPONENT_STEPS):
        network, result = _step(network, noise, q, estimate)
        q = _components(result, noise, robust=True)
    network, _ = _step(network, noise, q, estimate)

    # Reject blunders one by one
    snooped = bundle.snoop(network, estimate, most=MOST_REMOVED)
    kept = np.ones(len(noise), bool)
    kept[[one.ray for one in snooped.removed]] = False
    return _continued(snooped.result), snooped.removed, noise[kept]


def _solved(
    network: bundle.Network, noise: np.ndarray, estimate: Sequence[str]
) -> tuple[bundle.Bundle, np.ndarray, np.ndarray]:
    """Result, components and halves of a network without blunders."""
    result = bundle.adjust(network, estimate)
    for _ in range(COMPONENT_STEPS):
        q = _components(result, noise)
        network, result = _step(network, noise, q, estimate)
    return result, q, _halves(network, estimate)


def _step(
    network: bundle.Network, noise: np.ndarray, q: np.ndarray, estimate: Sequence[str]
) -> tuple[bundle.Network, bundle.Bundle]:
    """Adjust with other components; the network then starts from the result."""
    weighted = replace(network, **_accuracy(noise, q[network.photo]))
    result = bundle.adjust(weighted, estimate)
    return _continued(result), result


def _halves(network: bundle.Network, estimate: Sequence[str]) -> np.ndarray:
    """Differences of halves over their standard deviations (h, 2): camera and board."""
    m, rng = len(network.exteriors), np.random.default_rng(1)
    ratios = []
    for k in range(HALVES if m >= 2 * MIN_PHOTOS else 0):
        order = rng.permutation(m) if k else np.argsort(np.arange(m) % 2, kind="stable")
        try:
            one, other = (
                bundle.adjust(network.only(np.sort(part)), estimate)
                for part in np.array_split(order, 2)
            )
        except ValueError:  # a half that does not determine the camera says nothing
            continue
        d = one.interior - other.interior
        C = one.covariance_interior + other.covariance_interior
        camera = d @ np.linalg.solve(C, d) / len(d)
        _, i, j = np.intersect1d(
            one.network.point_names, other.network.point_names, return_indices=True
        )
        d = one.points[i] - other.points[j]
        variance = one.sd_points[i] ** 2 + other.sd_points[j] ** 2
        known = variance > 0  # flat boards are held
        board = np.mean(d[known] ** 2 / variance[known]) if known.any() else 1.0
        ratios.append((camera, board))
    return np.sqrt(np.reshape(ratios, (-1, 2)))


# --- Which photos, and where they were taken ---


def chosen(photos: Sequence[Measured]) -> tuple[list[Measured], dict[str, str]]:
    """The photos of one camera with enough corners, and why others are left out."""
    left_out = {one.name: one.words for one in photos if one.words}
    good = []
    for one in photos:
        if one.words:
            continue
        if (n := len(one.ids)) < MIN_CORNERS:
            left_out[one.name] = (
                f"only {n} corners could be measured, and {MIN_CORNERS} are needed:"
                " show more of the board, sharp and larger"
            )
        else:
            good.append(one)
    # The camera of most photos
    for what, key in SAME:
        values = [key(one) for one in good]
        usual = max(values, key=values.count, default=None)
        for one, value in zip(list(good), values):
            if value != usual:
                good.remove(one)
                left_out[one.name] = (
                    f"it was not taken as most are: its {what} is {_shown(value)},"
                    f" where most have {_shown(usual)}. {OTHER_CAMERA}"
                )
    # A copy would count as an observation of its own
    first = {one.pixels.tobytes(): one for one in reversed(good)}
    for one in list(good):
        if (other := first[one.pixels.tobytes()]) is not one:
            good.remove(one)
            left_out[one.name] = f"it is a copy of {other.name}"
    if len(good) < MIN_PHOTOS:
        named = {words: "" for words in left_out.values()}  # each reason once
        for name, words in left_out.items():
            named[words] += f"{', ' if named[words] else ''}{name}"
        reasons = "; ".join(f"{names}: {words}" for words, names in named.items())
        raise ValueError(
            f"{len(good)} of {len(photos)} photos show the board well enough, and"
            f" {MIN_PHOTOS} are the least, 12 to 20 a good number. {reasons}".rstrip()
        )
    return good, left_out


def _shown(values: tuple | None) -> str:
    """Values of EXIF in words; they may be missing."""
    known = [f"{v:g}" if isinstance(v, float) else str(v) for v in values or () if v]
    return " ".join(known) or "not stated"


def start_c(
    points: Iterable[np.ndarray], pixels: Iterable[np.ndarray], size: tuple[int, int]
) -> float:
    """Principal distance by the homographies of a flat board, to start from.

    Parameters
    ----------
    points : iterable of ndarray (n, 3)
        Of each photo, the points of the board that it shows, with Z = 0; in any unit.
    pixels : iterable of ndarray (n, 2)
        (column, row) of each in the photo, integers at pixel centres.
    size : (columns, rows)
        Of the photos, in pixels.

    Returns
    -------
    float
        c in pixels, no distortion assumed; the principal point is the image centre.

    References
    ----------
    Zhang 2000, A flexible new technique for camera calibration, section 3.1.

    Examples
    --------
    Two photos of a board 400 mm away, tilted about x and about y:

    >>> X, Y = np.mgrid[-40:50:10, -25:35:10].reshape(2, -1)
    >>> board = np.column_stack([X, Y, 0 * X])
    >>> tilts = rotation.matrix(0.5, 0, 0), rotation.matrix(0, 0.5, 0)
    >>> seen = []
    >>> for x, y, z in (M @ board.T for M in tilts):
    ...     image = 900 * np.stack([x, -y], 1) / (400 - z[:, None])
    ...     seen.append(image + (319.5, 239.5))
    >>> print(f"{start_c([board, board], seen, (640, 480)):.0f}")
    900
    """
    flat = [(one @ TO_OPENCV).astype("f4") for one in points]
    seen = [one[:, None].astype("f4") for one in pixels]
    c = cv2.initCameraMatrix2D(flat, seen, size)[0, 0]
    usual = max(size)  # a phone's; fronto-parallel photos have no c in them
    return float(c) if 0.2 * usual < c < 20 * usual else float(usual)


def _start_exterior(
    one: Measured, board: Board, lens: Camera, pixel_size: float
) -> np.ndarray:
    """Exterior orientation (6,) in the board's frame, by resection of a plane."""
    c, (u, v) = lens.c / pixel_size, frames.image_centre(one.image_size)
    K = np.array([[c, 0, u], [0, c, v], [0, 0, 1]])
    points = board.points[one.ids] @ TO_OPENCV
    _, turn, shift = cv2.solvePnP(points, one.pixels, K, None, flags=cv2.SOLVEPNP_IPPE)
    R = cv2.Rodrigues(turn)[0]
    M = TO_OPENCV @ R @ TO_OPENCV
    station = -(TO_OPENCV @ R.T @ shift).ravel()
    return np.concatenate([station, rotation.angles(M)])


def between_directions(exteriors: np.ndarray) -> np.ndarray:
    """Angles (m, m) between the directions in which photos look, in radians."""
    axes = imaging.attitude(exteriors)[:, 2]
    return np.arccos(np.clip(axes @ axes.T, -1, 1))


def _refuse_parallel(exteriors: np.ndarray) -> None:
    """Refuse photos that all look along one direction."""
    tilt = between_directions(exteriors).max()
    if tilt < MIN_TILT:
        raise ValueError(
            f"all photos look the same way, within {np.degrees(tilt):.0f} degrees: then"
            " the principal distance cannot be told from the distance of the board."
            " Take photos from the left, the right, above and below, tilted by 30 to 50"
            " degrees"
        )


# --- The network, and the accuracy of its rays ---


def _network(
    photos: Sequence[Measured],
    board: Board,
    lens: Camera,
    exteriors: np.ndarray,
    pixel_size: float,
    flat: bool,
) -> bundle.Network:
    """Network of all corners, with the covariances that the grey values give."""
    photo = np.repeat(np.arange(len(photos)), [len(one.ids) for one in photos])
    ids, pixels, noise = (
        np.concatenate([getattr(one, name) for one in photos])
        for name in ("ids", "pixels", "covariance")
    )
    # A point in one photo alone has no height
    seen = np.bincount(ids, minlength=len(board.points))
    kept = (seen > 1)[ids] | flat
    photo, ids, pixels, noise = photo[kept], ids[kept], pixels[kept], noise[kept]
    names, point = np.unique(ids, return_inverse=True)
    place = {name: i for i, name in enumerate(names.tolist())}
    bars = [
        (place[one], place[other], length, sd)
        for one, other, length, sd in board.bars
        if one in place and other in place
    ]
    xy, covariance = frames.pixel_to_photo(
        pixels, photos[0].image_size, pixel_size, covariance=noise
    )
    return bundle.Network(
        *(lens, exteriors, board.points[names], photo, point, xy),
        covariance=covariance,
        fixed=np.arange(len(names)) if flat else (),
        scale_bars=() if flat else bars,
        photo_names=[one.name for one in photos],
        point_names=names.tolist(),
    )


def _accuracy(noise: np.ndarray, q: np.ndarray) -> dict:
    """Covariances (k, 2, 2) in mm^2 with a component q (k,) in mm, and their roots."""
    C = noise + q[:, None, None] ** 2 * np.eye(2)
    return {"covariance": C, "sigma": np.sqrt(np.diagonal(C, axis1=1, axis2=2))}


def _components(
    result: bundle.Bundle, noise: np.ndarray, robust: bool = False
) -> np.ndarray:
    """Component q (m,) in mm with which v'Pv of each photo is what is expected.

    The expectation of v^2 is r (noise + q^2), with the redundancy number r.
    """
    r = np.maximum(result.redundancy_numbers, UNCONTROLLED)
    square = result.residuals**2 / r
    noise = np.diagonal(noise, axis1=1, axis2=2)
    q = np.zeros(len(result.exteriors))
    for j in range(len(q)):
        of_photo = result.network.photo == j
        q[j] = _component(square[of_photo], noise[of_photo], r[of_photo], robust)
    return q


def _component(
    square: np.ndarray, noise: np.ndarray, r: np.ndarray, robust: bool
) -> float:
    """Component of one photo, by v^2 / r, noise and redundancy number (n, 2)."""

    def excess(variance: float) -> float:
        ratio = square / (noise + variance)
        if robust:
            return float(np.median(ratio)) / MEDIAN_CHI_SQUARE - 1
        return float(np.average(ratio, weights=r)) - 1

    least = LEAST_COMPONENT * float(np.median(noise))
    if excess(least) <= 0:
        return float(np.sqrt(least))
    return float(np.sqrt(scipy.optimize.brentq(excess, least, 10 * square.max())))


def _continued(result: bundle.Bundle) -> bundle.Network:
    """The network with its result as start values."""
    return replace(
        result.network,
        cameras=result.cameras,
        exteriors=result.exteriors,
        points=result.points,
    )
