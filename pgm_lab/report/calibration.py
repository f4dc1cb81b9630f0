"""The report of a calibration: the camera, what it is worth, and what is missing."""

from functools import cached_property
from typing import Any

import numpy as np

from pgm_lab import bundle
from pgm_lab._rounding import fixed, rounded, scientific
from pgm_lab.calibration import Calibration, quality
from pgm_lab.calibration.solve import between_directions
from pgm_lab.camera import PARAMETERS
from pgm_lab.report import _page, _tables
from pgm_lab.report._page import Table, as_html, as_text
from pgm_lab.report._tables import UNITS

__all__ = ["html", "text"]

TITLE = "Camera calibration"

# Limits of the findings
FEW = 10  # photos
EMPTY = 0.2  # of the cells of the image without a corner
LEAST_ROLL, LEAST_TILT = 60.0, 40.0  # degrees
LEAST_DISTANCES = 1.2  # the farthest station over the nearest
CORRELATED = 0.9
OTHER_ZOOM = 4.0  # standard deviations of a photo's own c
SMALL_ZOOM = 0.001  # of c, which nobody would call a zoom
POOR = 3.0  # times the median component, and px that one can do something about
POOR_PX = 0.2
POWERS = {"K1": 2, "K2": 4, "K3": 6, "P1": 1, "P2": 1}  # of c, for x / c
BENT = 3.0  # standard deviations of a point's height


def html(found: Calibration, *, about: str = "", nominal: bool = False) -> str:
    """Report a calibration as an HTML page that needs no other file.

    Parameters
    ----------
    found : Calibration
    about : str
        A sentence for the head of the report.
    nominal : bool
        Whether the size of a pixel was only assumed: lengths in the camera are then
        given in pixels alone.
    """
    from pgm_lab.report import _figures  # matplotlib only when it is needed

    case = Case(found, nominal)
    names = {*(one.name for one in found.photos), *found.left_out, about} - {""}
    draw = _figures.of_calibration(case)
    return as_html(TITLE, case.sections(about, False, draw), names)


def text(
    found: Calibration, *, about: str = "", nominal: bool = False, short: bool = False
) -> str:
    """Report a calibration in plain text; `short` leaves out the tables of photos."""
    return as_text(TITLE, Case(found, nominal).sections(about, short))


class Case(_page.Case):
    """What the sentences of the report need to know of a calibration."""

    NAME = "calibration"
    suspects = ()  # data snooping has rejected them

    def __init__(self, found: Calibration, nominal: bool) -> None:
        self.found, self.result, self.nominal = found, found.result, nominal
        self.network = found.result.network

    @property
    def values(self) -> dict[str, Any]:
        """What both templates are given."""
        return super().values | {"found": self.found, "result": self.result}

    # --- The camera ---

    @cached_property
    def sd(self) -> dict[str, float]:
        """Standard deviations of the parameters that were estimated."""
        sd = np.sqrt(np.diagonal(self.found.covariance))
        return dict(zip(self.result.estimate, sd.tolist()))

    @property
    def c(self) -> tuple[str, str]:
        """Principal distance and its sd in pixels, as they are written."""
        c, size = self.found.camera.c, self.found.pixel_size
        return scientific(c / size, self.sd.get("c", 0.0) / size)

    @property
    def camera_mm(self) -> tuple[str, str]:
        """Principal distance and its sd in mm, as they are written."""
        c, sd = (np.array([v]) for v in (self.found.camera.c, self.sd.get("c", 0.0)))
        return rounded(c, sd)[0], rounded(sd, sd)[0]

    @property
    def view(self) -> tuple[float, float]:
        """Field of view across and down, in degrees, without the lens's distortion."""
        half = np.array(self.found.image_size) / 2 * self.found.pixel_size
        across, down = np.degrees(2 * np.arctan(half / self.found.camera.c))
        return float(across), float(down)

    @property
    def rms(self) -> float:
        """Root mean square of the residuals of a coordinate, in px."""
        return float(np.sqrt(np.mean(self.result.residuals**2)) / self.found.pixel_size)

    @cached_property
    def rays(self) -> tuple[float, float]:
        """Standard deviation of a ray in the middle, and at the worst corner, in px."""
        columns, rows = self.found.image_size
        ends = [(0, 0), (columns - 1, 0), (0, rows - 1), (columns - 1, rows - 1)]
        middle = ((columns - 1) / 2, (rows - 1) / 2)
        sd = self.found.ray_sd(np.array([middle, *ends], float))
        return float(sd[0]), float(sd[1:].max())

    @property
    def correlated(self) -> list[tuple[str, str, float]]:
        """Pairs of interior parameters that the photos hardly tell apart."""
        interior = set(self.result.interior_names)
        pairs = bundle.correlations(self.result, CORRELATED)
        return [pair for pair in pairs if {*pair[:2]} <= interior]

    def camera_table(self) -> Table:
        """Return the ten parameters: in mm, and as OpenCV counts them.

        With pixels as the unit of c, x0 and y0, and with c as that of the lens.
        """
        rows = []
        for name in PARAMETERS:
            value, sd = getattr(self.found.camera, name), self.sd.get(name)
            scale = self.found.camera.c ** POWERS.get(name, 0)
            if UNITS[name] == "mm":
                scale = 1 / self.found.pixel_size
            cells: list[str] = []
            for by in (1.0, scale):
                v = np.array([by * value])
                if not sd:
                    cells += f"{v[0]:.6g}", "held"
                elif UNITS[name] == "mm":
                    d = np.array([by * sd])
                    cells += rounded(v, d)[0], rounded(d, d)[0]
                else:
                    cells += scientific(v[0], by * sd)
            rows.append([name, *cells[:2], UNITS[name], *cells[2:]])
        header = ["parameter", "value", "sd", "unit", "in px, or for x / c", "sd"]
        kept = [0, 4, 5] if self.nominal else range(6)  # such mm mean nothing
        shown = [[row[i] for i in kept] for row in rows]
        return Table("Interior orientation", [header[i] for i in kept], shown)

    # --- The photos ---

    @cached_property
    def coverage(self) -> np.ndarray:
        """Corners in the cells of the image."""
        return quality.coverage(self.found)

    @property
    def empty(self) -> str:
        """Which parts of the image have no corner, in words; empty if few have none."""
        nothing = self.coverage == 0
        if np.mean(nothing) < EMPTY:
            return ""
        sides = {
            "left": nothing[:, 0],
            "right": nothing[:, -1],
            "upper": nothing[0],
            "lower": nothing[-1],
        }
        worst = [side for side, cells in sides.items() if np.mean(cells) >= 0.5]
        return " and ".join(f"the {side} edge" for side in worst) or "several parts"

    @cached_property
    def roll(self) -> float:
        """Largest angle by which photos are turned about their axes, in degrees."""
        return quality.roll(self.found)

    @cached_property
    def tilt(self) -> float:
        """Largest angle between the directions of two photos, in degrees."""
        return float(self.tilts.max())

    @cached_property
    def tilts(self) -> np.ndarray:
        """Angles (m, m) between the directions of the photos, in degrees."""
        return np.degrees(between_directions(self.result.exteriors))

    @cached_property
    def distances(self) -> np.ndarray:
        """Distances (m,) of the stations from the middle of the board, in mm."""
        middle = self.result.points.mean(axis=0)
        return np.linalg.norm(self.result.exteriors[:, :3] - middle, axis=1)

    @cached_property
    def zoom(self) -> tuple[np.ndarray, np.ndarray]:
        """What c would be larger in each photo, as a share, and its sd."""
        dc, sd = quality.zoom(self.found)
        return dc / self.found.camera.c, self.found.factor[0] * sd / self.found.camera.c

    @property
    def zoomed(self) -> list[str]:
        """Photos whose own c differs."""
        dc, sd = self.zoom
        other = (np.abs(dc) > OTHER_ZOOM * sd) & (np.abs(dc) > SMALL_ZOOM)
        return [one.name for one, is_other in zip(self.found.photos, other) if is_other]

    @property
    def poor(self) -> list[str]:
        """Photos whose corners are off by much more than those of the others."""
        q = self.found.component
        much = (q > POOR * np.median(q)) & (q > POOR_PX)
        return [one.name for one, is_much in zip(self.found.photos, much) if is_much]

    def photos_table(self) -> Table:
        """Return what each photo shows, and how well."""
        found, network = self.found, self.network
        m = len(found.photos)
        number = np.bincount(network.photo, minlength=m)
        square = np.bincount(network.photo, np.sum(self.result.residuals**2, axis=1), m)
        rms = np.sqrt(square / (2 * np.maximum(number, 1))) / found.pixel_size
        dc, sd = self.zoom
        tilt = self.tilts[np.argmin(self.tilts.sum(axis=0))]
        columns = [
            [one.name for one in found.photos],
            [str(one) for one in number],
            fixed(np.array([one.blur for one in found.photos]), 2),
            fixed(found.component, 3),
            fixed(rms, 3),
            fixed(self.distances, 0),
            fixed(tilt, 0),
            rounded(100 * dc, 100 * sd),
            rounded(100 * sd, 100 * sd),
        ]
        header = "photo corners blur own residuals distance tilt c sd".split()
        caption = (
            "Photos: blur across an edge, the error of its own that a photo adds to the"
            " noise of its corners, rms of its residuals (px); distance from the board"
            " (mm), tilt against the photo in the middle of all (degrees), and by how"
            " much its own c would be larger (%)"
        )
        return Table(caption, header, list(zip(*columns)))

    # --- The board ---

    @property
    def bent(self) -> tuple[float, str, float, float] | None:
        """Height of the point farthest off the plane, its number, sd; rms of all."""
        sd = self.found.sd_shape[:, 2]
        if not np.any(sd > 0):
            return None
        z = self.found.shape[:, 2]
        i = int(np.argmax(np.abs(z)))
        if not np.any(np.abs(z) > BENT * sd):
            return None
        name = str(self.network.point_names[i])
        return float(z[i]), name, float(sd[i]), float(np.sqrt(np.mean(z**2)))

    @property
    def flat(self) -> tuple[float, float, float]:
        """C of a flat board in px, how many sd that is off, and its sigma0."""
        flat, c = self.found.flat, self.found.camera.c
        off = (flat.cameras[0].c - c) / self.sd.get("c", np.nan)
        return flat.cameras[0].c / self.found.pixel_size, float(off), flat.sigma0

    def bars_table(self) -> Table | None:
        """Return the scale bars, measured and computed."""
        known = _tables.known(self.result)
        return known[0] if len(self.network.scale_bars) else None
