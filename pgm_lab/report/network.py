"""The report of a bundle adjustment, and what network.j2 puts into sentences."""

from functools import cached_property
from typing import Any

import numpy as np
import scipy

from pgm_lab import _validate
from pgm_lab._rounding import plain
from pgm_lab.adjustment.outliers import NAMES
from pgm_lab.adjustment.result import UNCONTROLLED
from pgm_lab.bundle.datum import is_controlled
from pgm_lab.bundle.network import Network
from pgm_lab.bundle.refuse import LOOKING, mirrored_image, mirrored_object
from pgm_lab.bundle.reliability import correlations, critical_value, significance
from pgm_lab.bundle.result import Bundle
from pgm_lab.bundle.snooping import Snooping
from pgm_lab.camera import imaging
from pgm_lab.report import _page, _tables
from pgm_lab.report._page import Finding, as_html, as_text, count
from pgm_lab.report._tables import UM

TITLE = "Bundle adjustment"

# Limits of the findings
ALPHA = 0.05  # probability of calling a right model wrong
IN_UM = 0.01  # sigma0 below this share of what was stated: 1 µm given as 1 mm is 0.001
GROSS = 1.5  # times the limit of |w|, or |tau|
SPOILT = 2.0  # times the stated standard deviation: what is judged by sigma0 is not
MAX_COMPARED = 50  # suspects that are compared with each other
ALIKE = 0.5  # largest part of a distance by which an error may miss it
CORRELATED = 0.9
HARDLY = 0.1  # redundancy number below which nine tenths of a blunder stay hidden
FEW_RAYS = 6  # three points orient a photo without any control
WEAK = 3.0  # times the median standard deviation of the projection centres

# Distances from the middle of a photo in mm that no camera has: the smallest endoscope
# is 0.6 mm wide, the largest aerial photo 230 mm x 460 mm
NEAREST, FARTHEST = 0.25, 300.0
FINEST = 1e-5  # mm; nobody has measured an image to 10 nm
SCALE = 3.0  # by which usable start values never miss the size of the image, or c
UNEXPLAINED = 0.4  # of the spread of the coordinates; start values are too rough above
NARROW = 0.3  # smaller singular value of A over the larger: points in a line below
WIDE = 2.0  # x / c of 63 degrees off the axis


def html(found: Bundle | Snooping, *, about: str = "") -> str:
    """Report a bundle adjustment as an HTML page that needs no other file.

    Parameters
    ----------
    found : Bundle or Snooping
        What `adjust` or `snoop` returns.
    about : str
        A sentence for the head of the report: the object, the files, the date.

    Returns
    -------
    str
        The page with its figures, for light and dark screens and for paper.
    """
    from pgm_lab.report import _figures  # matplotlib only when it is needed

    case = _case(found)
    network, draw = case.network, _figures.of_network(case)
    names = {*network.photo_names, *network.point_names, about} - {""}
    return as_html(TITLE, case.sections(about, False, draw), names)


def text(found: Bundle | Snooping, *, about: str = "", short: bool = False) -> str:
    """Report a bundle adjustment in plain text.

    Parameters
    ----------
    found, about
        As for `html`.
    short : bool
        Leave out the tables of photos and points.

    Returns
    -------
    str
        Lines of at most 88 characters, but for wide tables.

    Examples
    --------
    >>> from pgm_lab import bundle
    >>> from pgm_lab.camera import Camera
    >>> from pgm_lab.datasets import muliawan2013
    >>> data = muliawan2013()
    >>> measured = data.photo, data.point, data.xy, data.sigma
    >>> camera = Camera(*data.interior)
    >>> network = bundle.Network(camera, data.exteriors, data.object_points, *measured)
    >>> report = text(bundle.adjust(network), short=True)
    >>> report.splitlines()[3][:55]
    '9 photos of 50 points, taken with one camera: 450 rays.'
    """
    return as_text(TITLE, _case(found).sections(about, short))


def _case(found: Bundle | Snooping) -> "Case":
    if isinstance(found, Snooping):
        return Case(found.result, found)
    return Case(_validate.instance(found, Bundle, "found"))


def _three(value: float) -> str:
    """Write a number with three decimals, or more if they are zeros."""
    return f"{value:.3f}" if value >= 0.1 else plain(value, 3)


class Case(_page.Case):
    """What the sentences of the report need to know of a result."""

    NAME = "network"

    def __init__(self, result: Bundle, snooping: Snooping | None = None) -> None:
        self.result, self.network = result, result.network
        self.snooping = snooping
        self.stated = result.sigma0_prior or 1.0
        self.critical = critical_value(result)
        self.test_name = NAMES[result.residual_test]
        self.controlled = is_controlled(self.network)

    @property
    def values(self) -> dict[str, Any]:
        """What both templates are given."""
        return super().values | {
            "result": self.result,
            "network": self.network,
            "snooping": self.snooping,
            "mirrored_image": mirrored_image(self.result),
            "mirrored_object": mirrored_object(self.result),
            "tables": _tables,
            "three": _three,
            "infinity": float("inf"),
            "LOOKING": LOOKING,
        }

    # --- Names ---

    def point_of(self, ray: int) -> object:
        """Name of the point of a ray."""
        return self.network.point_names[self.network.point[ray]]

    def photo_of(self, ray: int) -> object:
        """Name of the photo of a ray."""
        return self.network.photo_names[self.network.photo[ray]]

    def rays(self, rays: np.ndarray) -> list[str]:
        """Name rays by the ids of their points and photos."""
        return [f"point {self.point_of(k)} in photo {self.photo_of(k)}" for k in rays]

    def with_test(self, suspects: list[tuple[str, float]]) -> list[str]:
        """Name observations with their w, or tau."""
        test = self.result.residual_test
        return [f"{name} ({test} = {w:.1f})" for name, w in suspects]

    def named_with_rays(self, photos: np.ndarray) -> list[str]:
        """Name photos with the number of their rays."""
        rays = self.network.rays_of_photos
        names = self.network.photo_names
        return [f"{names[i]} ({count(rays[i], 'ray')})" for i in photos]

    # --- The summary ---

    @property
    def unknowns(self) -> int:
        """Number of unknowns."""
        return len(self.result.names) + int(np.sum(~self.network.held))

    @property
    def observed(self) -> list[str]:
        """What stands against the unknowns: with them it gives the redundancy."""
        network = self.network
        numbers = {
            "image coordinate": 2 * len(network.xy),
            "control coordinate": int(np.sum(network.known & ~network.held)),
            "scale bar": len(network.scale_bars),
        }
        inner = self.result.redundancy + self.unknowns - sum(numbers.values())
        numbers["inner constraint"] = inner
        return [count(number, noun) for noun, number in numbers.items() if number]

    @property
    def weighted(self) -> bool:
        """Whether control coordinates or scale bars are observations too."""
        network = self.network
        return len(network.scale_bars) > 0 or bool(
            np.any(network.known & ~network.held)
        )

    @property
    def one_sigma(self) -> float | None:
        """Standard deviation of all image coordinates in µm, if it is the same."""
        sigma = self.network.sigma
        return UM * sigma.flat[0] if np.ptp(sigma) == 0 else None

    @property
    def interval(self) -> np.ndarray:
        """Ends of what sigma0 is by chance."""
        redundancy = self.result.redundancy
        ends = scipy.stats.chi2.ppf([ALPHA / 2, 1 - ALPHA / 2], redundancy)
        return self.stated * np.sqrt(ends / redundancy)

    # --- Blunders ---

    @cached_property
    def suspects(self) -> np.ndarray:
        """Rays with a standardised residual above its limit, the largest first."""
        largest = np.max(np.abs(self.result.standardized), axis=1, initial=0)
        suspects = np.flatnonzero(largest > self.critical)
        return suspects[np.argsort(-largest[suspects], kind="stable")]

    @property
    def by_chance(self) -> float:
        """Number of standardised residuals that are above the limit by chance."""
        return self.result.standardized.size / 1000  # as critical_value has it

    @property
    def more_than_chance(self) -> bool:
        """Whether chance does not explain the number of suspects."""
        found = np.sum(np.abs(self.result.standardized) > self.critical)
        return bool(found > scipy.stats.poisson.ppf(1 - ALPHA, self.by_chance))

    @cached_property
    def suspected_control(self) -> list[tuple[str, float]]:
        """Control coordinates and scale bars above the limit, the largest first."""
        network, result = self.network, self.result
        names = network.point_names
        found: list[tuple[str, float]] = []
        if network.control is not None:
            index, w = network.control[0], result.control_standardized
            for row, axis in np.argwhere(np.abs(w) > self.critical):
                name = f"{'XYZ'[axis]} of control point {names[index[row]]}"
                found.append((name, float(w[row, axis])))
        w = result.scale_bar_standardized
        for bar in np.flatnonzero(np.abs(w) > self.critical):
            a, b = network.scale_bars[bar, :2].astype(int)
            found.append((f"the scale bar {names[a]} to {names[b]}", float(w[bar])))
        return sorted(found, key=lambda one: -abs(one[1]))

    @property
    def control_first(self) -> bool:
        """Whether a control coordinate or a scale bar has the largest residual."""
        suspects = self.suspected_control
        rays = np.max(np.abs(self.result.standardized), initial=0)
        return bool(suspects) and bool(abs(suspects[0][1]) > rays)

    @property
    def least_control(self) -> bool:
        """Whether there are as many control coordinates as motions to stop."""
        needed = 6 if len(self.network.scale_bars) else 7
        return bool(np.sum(self.network.known) == needed)

    @property
    def gross(self) -> bool:
        """Whether a blunder makes sigma0 so large that nothing can be judged by it."""
        result = self.result
        if not result.sigma0 > SPOILT * self.stated:
            return False
        w = (
            result.standardized,
            result.control_standardized,
            result.scale_bar_standardized,
        )
        largest = max(np.max(np.abs(one), initial=0) for one in w)
        if result.sigma0_prior is not None:  # w counts in stated sd: count in sigma0
            largest *= self.stated / result.sigma0
        return bool(largest > GROSS * self.critical)

    @cached_property
    def interchanged(self) -> list[tuple[int, int]]:
        """Pairs of suspected rays of one photo, each measured at the other's place.

        The estimated error -v / r of one is then the difference of the coordinates,
        that of the other its opposite.
        """
        network, rays = self.network, self.suspects[:MAX_COMPARED]
        r = self.result.redundancy_numbers[rays]
        error = -self.result.residuals[rays] / np.where(r > UNCONTROLLED, r, np.inf)
        a, b = np.triu_indices(len(rays), 1)
        difference = network.xy[rays[a]] - network.xy[rays[b]]
        miss = np.array([error[a], -error[b]]) - difference
        miss = np.hypot(*miss.transpose(2, 0, 1))
        pair = np.all(miss < ALIKE * np.hypot(*difference.T), axis=0)
        pair &= network.photo[rays[a]] == network.photo[rays[b]]
        return [(int(i), int(j)) for i, j in zip(rays[a[pair]], rays[b[pair]])]

    # --- What else to look at ---

    @cached_property
    def doubt(self) -> Finding | None:
        """What is wrong with the image coordinates, if anything seems to be."""
        return doubt(self.network)

    @property
    def changed_c(self) -> tuple[float, float] | None:
        """The c that is not at all what its start value says, and that one."""
        start = self.network.interior[:, 0]
        c = np.array([camera.c for camera in self.result.cameras])
        ratio = np.maximum(c / start, start / c)
        worst = int(np.argmax(ratio))
        if self.result.status != "converged" or ratio[worst] <= SCALE:
            return None
        return c[worst], start[worst]

    @cached_property
    def correlated(self) -> dict[str, Any]:
        """Strong correlations in words, by what correlates."""
        pairs = correlations(self.result, CORRELATED)
        interior = set(self.result.interior_names)
        kinds: tuple[list[str], ...] = ([], [], [])
        for one, other, r in pairs:
            words = f"{one} with {other} ({r:.3f})"
            kinds[len(interior & {one, other})].append(words)
        photos, mixed, camera = kinds
        return {"camera": camera, "mixed": mixed, "photos": photos, "any": bool(pairs)}

    @cached_property
    def insignificant(self) -> list[str]:
        """Parameters of the camera that do not differ from zero."""
        return [
            f"{one.name} (t = {one.t:.1f}, at most {plain(UM * one.effect)} µm in the"
            " image)"
            for one in significance(self.result, ALPHA)
            if not one.significant
        ]

    @cached_property
    def uncontrolled(self) -> list[str]:
        """Rays whose residual shows next to nothing of an error, the worst first."""
        least = np.min(self.result.redundancy_numbers, axis=1)
        rays = np.flatnonzero(least < HARDLY)
        if not self.result.redundancy > 0:
            return []
        rays = rays[np.argsort(least[rays], kind="stable")]
        numbers = np.maximum(least[rays], 0)
        return [f"{name} ({r:.2f})" for name, r in zip(self.rays(rays), numbers)]

    @cached_property
    def two_rays(self) -> list[object]:
        """Points of two rays that are not held."""
        network = self.network
        free = ~np.all(network.held, axis=1)
        two = np.flatnonzero((network.rays_of_points == 2) & free)
        return [network.point_names[j] for j in two]

    @cached_property
    def weak_photos(self) -> np.ndarray:
        """Indices of photos with few rays or an uncertain projection centre."""
        sd = np.linalg.norm(self.result.sd_exteriors[:, :3], axis=1)
        uncertain = sd > WEAK * np.median(sd)
        return np.flatnonzero((self.network.rays_of_photos < FEW_RAYS) | uncertain)


# --- Image coordinates in another unit, or with axes that point another way ---
#
# A free network adjusts in any unit: coordinates in metres give a camera of
# c = 0.035 mm and a sigma0 that looks splendid. So they are compared with what the
# start values make of them: measured = A computed + t, with A (2, 2) near the identity
# if all is well and t of each photo, which takes up most of the error of rough angles.

COORDINATES = "Image coordinates"


def doubt(network: Network) -> Finding | None:
    """Say that the image coordinates are not mm with x to the right and y up."""
    A = _compared(network)
    farthest = float(np.hypot(*network.xy.T).max())
    times = 1.0 if A is None else float(np.sqrt(np.abs(np.linalg.det(A))))
    ratio = max(times, 1 / times)
    if ratio <= SCALE:  # right, or all in one wrong unit, or nothing to compare with
        ratio = 0.0
        times = 1e3 if farthest > FARTHEST else 1e-3 if farthest < NEAREST else 1.0
    unit = "centimetres" if times > 0.03 else "metres"
    if times >= 1:
        unit = "pixels or micrometres" if times > 1 else ""
    values = {"unit": unit, "ratio": ratio, "times": times, "farthest": farthest}
    values |= {"reflected": _reflected(A), "sigma": float(np.median(network.sigma))}
    found = _page.sections("doubt.j2", values | _page.constants(__name__))[0].findings
    return found[0] if found else None


def _compared(network: Network) -> np.ndarray | None:
    """Return A (2, 2) of measured = A computed + t; None if start values are rough."""
    # Image coordinates of the start values, without lens and x0, y0
    of_ray = network.interior[network.camera[network.photo]]
    ray, _ = imaging.ray(
        network.exteriors[network.photo], network.points[network.point]
    )
    front = ray[:, 2] < 0
    tangents = -ray[:, :2] / np.where(front, ray[:, 2], -1.0)[:, None]
    usable = front & (np.hypot(*tangents.T) < WIDE)
    if np.sum(usable) < max(6, 0.8 * len(usable)):
        return None
    # Minus the mean of each photo
    photo = network.photo[usable]
    rays = np.maximum(np.bincount(photo), 1)

    def reduced(xy: np.ndarray) -> np.ndarray:
        means = np.stack([np.bincount(photo, a) / rays for a in xy[usable].T], axis=1)
        return xy[usable] - means[photo]

    p, m = reduced(of_ray[:, :1] * tangents), reduced(network.xy)
    A = np.linalg.lstsq(p, m, rcond=None)[0].T
    unexplained = np.linalg.norm(m - p @ A.T)
    s = np.linalg.svd(A, compute_uv=False)
    if unexplained > UNEXPLAINED * np.linalg.norm(m) or s[1] <= NARROW * s[0]:
        return None
    return A


def _reflected(A: np.ndarray | None) -> int | None:
    """Return 2 theta in degrees of a reflection (cos, sin; sin, -cos), else None."""
    if A is None or np.linalg.det(A) > 0:
        return None
    twice = np.degrees(np.arctan2(A[0, 1] + A[1, 0], A[0, 0] - A[1, 1]))
    nearest = int(90 * np.round(twice / 90))
    return abs(nearest) if abs(nearest) == 180 else nearest
