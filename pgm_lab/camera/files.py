"""A calibrated camera as a file: camera.json, and the files of other programs.

camera.json states its convention in words, the ten parameters with their standard
deviations and covariance, and the image they belong to; `read` gives back each bit.

OpenCV, COLMAP and Metashape have the lens model of lens="forward" without b1 and b2,
in units of c, with y down, and convert exactly: k_i = K_i c^(2i), p1 = -P2 c,
p2 = P1 c. Another camera is fitted to theirs by least squares over the image. The
largest departure that is left, in pixels, stands in the file, and one above `LARGEST`
is refused.
"""

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import least_squares

from pgm_lab import _validate, frames
from pgm_lab.camera import _document, imaging
from pgm_lab.camera._document import Content
from pgm_lab.camera.model import PARAMETERS, Camera, ideal
from pgm_lab.io import files
from pgm_lab.io.files import printable

LARGEST = 0.1  # px, about the uncertainty of a ray after a good calibration
PROGRAMS = ("opencv", "colmap", "metashape")
GRID = 25  # places a side, from edge to edge, on which models are compared


@dataclass(frozen=True, eq=False)
class CameraFile:
    """A camera, how well it is known, and the image it belongs to.

    Attributes
    ----------
    camera : Camera
    image_size : (columns, rows)
        Of the whole photo, as it lies on the sensor.
    pixel_size : float
        Side of a pixel in mm.
    nominal : bool
        Whether the pixel size was only assumed, as 0.001 mm: c, x0, y0, ... are then in
        such units, and rays are right all the same.
    estimate : tuple of str
        The parameters that were estimated, in the order of the covariance.
    covariance : ndarray (u, u) or None
        Of these, in mm and its powers; None if it is not known.
    about : str
        Where the camera comes from.
    """

    camera: Camera
    image_size: tuple[int, int]
    pixel_size: float
    nominal: bool = False
    estimate: tuple[str, ...] = ()
    covariance: np.ndarray | None = field(default=None, repr=False)
    about: str = ""

    def text(self) -> str:
        """What stands in camera.json; ValueError if something is not as described."""
        _validate.instance(self.camera, Camera, "camera")
        columns, rows = (int(n) for n in _validate.image_size(self.image_size))
        C = self.covariance
        return _document.text(
            Content(
                {name: getattr(self.camera, name) for name in PARAMETERS},
                self.camera.lens,
                (columns, rows),
                _validate.positive_number(self.pixel_size, "pixel_size", "mm"),
                _validate.flag(self.nominal, "nominal"),
                tuple(_validate.texts(self.estimate, "names")),
                None if C is None else _validate.finite(C, "covariance"),
                self.about,
            )
        )


@dataclass(frozen=True, eq=False)
class OpenCV:
    """A camera as `cv2` takes it.

    Attributes
    ----------
    matrix : ndarray (3, 3)
        fx, fy, cx, cy in pixels, whole numbers at pixel centres.
    distortion : ndarray (5,)
        k1, k2, p1, p2, k3.
    image_size : (columns, rows)
    departure : float
        From the camera, in pixels, at most over the image; 0 if it converts exactly.
    """

    matrix: np.ndarray
    distortion: np.ndarray
    image_size: tuple[int, int]
    departure: float


# --- camera.json ---


def write(
    path: str | os.PathLike,
    camera: Camera,
    *,
    image_size: tuple[int, int],
    pixel_size: float,
    covariance: np.ndarray | None = None,
    names: Sequence[str] = PARAMETERS,
    nominal: bool = False,
    about: str = "",
    overwrite: bool = False,
) -> None:
    """Write a camera.json, which `read` gives back bit by bit.

    Parameters
    ----------
    path : str or path
    camera : Camera
    image_size : (columns, rows)
        Of the whole photo, as it lies on the sensor.
    pixel_size : float
        In mm.
    covariance : ndarray (u, u), optional
        Of the parameters `names`, in mm and its powers, as `bundle` estimates it.
    names : sequence of str
        Some of `PARAMETERS`; the others were held.
    nominal : bool
        Whether the pixel size was only assumed.
    about : str
        Where the camera comes from, in words.
    overwrite : bool
        Whether a file of this name may be replaced.

    Raises
    ------
    ValueError
        If something is not as described, or c and pixel size cannot both be in mm.
    FileExistsError, OSError
        If the file is there already, or cannot be written.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> camera = Camera(4.2, 0.01, K1=1.3e-3, lens="forward")
    >>> with TemporaryDirectory() as folder:
    ...     file = f"{folder}/camera.json"
    ...     write(file, camera, image_size=(4000, 3000), pixel_size=0.0014)
    ...     Camera.read(file) == camera
    True
    """
    known = () if covariance is None else tuple(_validate.several(names, "names"))
    given = camera, image_size, pixel_size, nominal, known, covariance, about
    files.save({path: CameraFile(*given).text()}, overwrite=overwrite)


def read(path: str | os.PathLike) -> CameraFile:
    """Read a camera.json.

    Raises
    ------
    ValueError
        If it is damaged, contradicts itself, has another convention, or is the file of
        another program: in a sentence that names what is wrong.
    FileNotFoundError, OSError
        If it cannot be read.
    """
    content = _document.read(path)
    return CameraFile(
        Camera(**content.interior, lens=content.lens),
        content.image_size,
        content.pixel_size,
        content.nominal,
        content.names,
        content.covariance,
        content.about,
    )


def of_photo(
    camera: Camera | str | os.PathLike,
    image_size: Sequence[int],
    pixel_size: float | None = None,
    photo: str = "photo",
    held: int = 1,
) -> tuple[Camera, float | None]:
    """Camera and pixel size of a photo, from a camera.json if `camera` is its path.

    `held` is the orientation in the photo's EXIF, by which it was turned upright.

    Raises
    ------
    ValueError
        If the file is wrong, is of photos of another size, or has another pixel size;
        or if the photo does not lie as on the sensor.
    """
    if not isinstance(camera, str | os.PathLike):
        return _validate.instance(camera, Camera, "camera"), pixel_size
    found = read(camera)
    columns, rows = (int(n) for n in image_size)
    file = printable(camera)
    if held != 1 or (columns, rows) != found.image_size:
        slip = "was it reduced or cropped, or taken by another camera?"
        if held != 1 or (rows, columns) == found.image_size:
            slip = (
                "was it turned upright by its EXIF? The camera is that of photos as"
                " they lie on the sensor: take out the orientation in the EXIF"
            )
        raise ValueError(
            f"{photo} has {columns} x {rows} pixels, and the camera of {file}"
            f" {found.image_size[0]} x {found.image_size[1]}: {slip}"
        )
    if pixel_size is not None and pixel_size != found.pixel_size:
        raise ValueError(
            f"pixel_size is {pixel_size!r:.40}, and {file} has {found.pixel_size!r} mm:"
            " leave it out"
        )
    return found.camera, found.pixel_size


# --- Other programs ---


def to_opencv(
    camera: Camera,
    *,
    image_size: ArrayLike,
    pixel_size: float,
    largest: float = LARGEST,
) -> OpenCV:
    """Convert a camera to OpenCV's model: exactly, or by least squares over the image.

    Exact is lens="forward" without b1 and b2. Fitted, fx and fy differ for b1; there is
    nothing for b2, the shear.

    Parameters
    ----------
    camera : Camera
    image_size : (columns, rows)
    pixel_size : float
        In mm.
    largest : float
        Departure in pixels, anywhere in the image, beyond which ValueError is raised.

    Examples
    --------
    >>> camera = Camera(4.0, K1=0.001, lens="forward")
    >>> cv = to_opencv(camera, image_size=(4001, 3001), pixel_size=0.001)
    >>> cv.matrix[0], cv.distortion, cv.departure
    (array([4000.,    0., 2000.]), array([0.016, 0.   , 0.   , 0.   , 0.   ]), 0.0)
    """
    found, size, departure = _standard(camera, image_size, pixel_size, largest)
    fx, fy, cx, cy, k1, k2, k3, p1, p2, _ = found
    matrix = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])
    return OpenCV(matrix, np.array([k1, k2, p1, p2, k3]), size, departure)


def _standard(
    camera: Camera,
    image_size: ArrayLike,
    pixel_size: float,
    largest: float,
    skew: bool = False,
) -> tuple[list[float], tuple[int, int], float]:
    """fx, fy, cx, cy, k1, k2, k3, p1, p2, skew; the image size; the departure in px."""
    _validate.instance(camera, Camera, "camera")
    columns, rows = (int(n) for n in _validate.image_size(image_size))
    size = _validate.positive_number(pixel_size, "pixel_size", "mm")
    c, departure = camera.c, 0.0
    cx, cy = frames.photo_to_pixel((camera.x0, camera.y0), (columns, rows), size)
    radial = camera.K1 * c**2, camera.K2 * c**4, camera.K3 * c**6
    decentring = 0 - camera.P2 * c, camera.P1 * c  # not -0
    found = np.array([c / size, c / size, cx, cy, *radial, *decentring, 0])
    if camera.lens == "backward" or camera.b1 or camera.b2:
        pixels = _grid(columns, rows)
        photo = frames.pixel_to_photo(pixels, (columns, rows), size)
        rays = ideal(camera, photo) / (c, -c)  # y down
        free = 10 if skew else 9

        def residuals(p: np.ndarray) -> np.ndarray:
            return _imaged(np.append(p, found[free:]), rays) - pixels

        found[:free], departure = _fit(residuals, found[:free])
        _refuse_above(largest, departure, "b1, b2 or lens='backward'")
    return found.tolist(), (columns, rows), departure


def from_opencv(
    matrix: ArrayLike,
    distortion: ArrayLike,
    image_size: ArrayLike,
    pixel_size: float,
    largest: float = LARGEST,
) -> Camera:
    """Convert the camera matrix and distortion coefficients of OpenCV to a Camera.

    It has lens="forward". If fx and fy are equal, and there are no coefficients beyond
    k3, this is exact. Otherwise the ten parameters are fitted over the image.

    Parameters
    ----------
    matrix : array_like (3, 3)
        As `cv2.calibrateCamera` returns it.
    distortion : array_like
        k1, k2, p1, p2, k3, ...: 4, 5, 8, 12 or 14 numbers, or none.
    image_size : (columns, rows)
    pixel_size : float
        In mm; 0.001 if it is not known. Rays do not depend on it.
    largest : float
        As for `to_opencv`.

    Examples
    --------
    >>> K = [[4000, 0, 2000], [0, 4000, 1500], [0, 0, 1]]
    >>> from_opencv(K, [0.016, 0, 0, 0], (4001, 3001), 0.001).K1
    0.001
    """
    K = _validate.of_shape(matrix, (3, 3), "matrix")
    d = _validate.finite(distortion, "distortion").ravel()
    if d.size not in (0, 4, 5, 8, 12, 14):
        raise ValueError(
            f"distortion must be 4, 5, 8, 12 or 14 numbers, or none; got {d.size}"
        )
    (fx, skew, cx), (zero, fy, cy) = K[:2]
    if fx <= 0 or fy <= 0 or skew or zero or K[2].tolist() != [0, 0, 1]:
        raise ValueError(
            "matrix must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] with fx and fy above"
            f" zero; got {K.tolist()}"
        )
    columns, rows = (int(n) for n in _validate.image_size(image_size))
    size = _validate.positive_number(pixel_size, "pixel_size", "mm")
    c = float(fy * size)
    x0, y0 = frames.pixel_to_photo((cx, cy), (columns, rows), size, False).tolist()
    k1, k2, p1, p2, k3 = [*d.tolist(), 0, 0, 0, 0, 0][:5]
    lens = k1 / c**2, k2 / c**4, k3 / c**6, p2 / c, 0 - p1 / c
    start = [c, x0, y0, *lens, fx / fy - 1, 0]
    if fx != fy or np.any(d[5:]):
        import cv2

        pixels = _grid(columns, rows)
        rays = cv2.undistortPoints(pixels[:, None], K, d).reshape(-1, 2)
        ahead, still = np.c_[rays, np.ones(len(rays))], np.zeros(3)
        seen = np.asarray(cv2.projectPoints(ahead, still, still, K, d)[0])
        photo = frames.pixel_to_photo(seen[:, 0], (columns, rows), size, False)

        def residuals(p: np.ndarray) -> np.ndarray:
            at = rays * (p[0], -p[0])
            return (at + imaging.distortion(p[3:], at) + p[1:3] - photo) / size

        fitted, departure = _fit(residuals, start)
        start = fitted.tolist()
        _refuse_above(
            largest, departure, "coefficients beyond k3, or unequal fx and fy"
        )
    return Camera(**dict(zip(PARAMETERS, start)), lens="forward")


def _grid(columns: int, rows: int) -> np.ndarray:
    """Pixels (n, 2) all over an image, from edge to edge."""
    sides = (np.linspace(-0.5, n - 0.5, GRID) for n in (columns, rows))
    return np.stack(np.meshgrid(*sides), -1).reshape(-1, 2)


def _imaged(p: np.ndarray, rays: np.ndarray) -> np.ndarray:
    """Pixels of rays (n, 2) = (X, Y) / Z, y down: OpenCV's model, and a skew."""
    fx, fy, cx, cy, k1, k2, k3, p1, p2, skew = p
    x, y = (rays + imaging.distortion(np.array([k1, k2, k3, p2, p1, 0, 0]), rays)).T
    return np.stack([fx * x + skew * y + cx, fy * y + cy], -1)


def _fit(
    residuals: Callable[[np.ndarray], np.ndarray], start: ArrayLike
) -> tuple[np.ndarray, float]:
    """Parameters with the least residuals (n, 2), in pixels, and the largest one."""
    limits = dict.fromkeys(("xtol", "ftol", "gtol"), 1e-15)
    p = least_squares(lambda p: residuals(p).ravel(), start, x_scale="jac", **limits).x
    return p, float(np.hypot(*residuals(p).T).max())


def _refuse_above(largest: float, departure: float, what: str) -> None:
    if not departure <= largest:
        raise ValueError(
            f"fitted to the other lens model, which has no {what}, the camera departs"
            f" by up to {departure:.3g} px in the image, and the limit is"
            f" largest={largest:g}"
        )


def exchange(
    camera: Camera,
    program: str,
    *,
    image_size: ArrayLike,
    pixel_size: float,
    largest: float = LARGEST,
) -> str:
    """Return the text of a file with the camera for another program.

    Parameters
    ----------
    camera, image_size, pixel_size, largest
        As for `to_opencv`.
    program : {"opencv", "colmap", "metashape"}
        "opencv": a .yml for `cv2.FileStorage`, with image_width, image_height,
        camera_matrix, distortion_coefficients. "colmap": a cameras.txt with camera 1,
        as OPENCV, or FULL_OPENCV if there is a k3; its pixel centres lie at 0.5.
        "metashape": an .xml for Tools > Camera Calibration > Load, by the formula and
        the fields of Agisoft's manual; it was not tried in the program itself.

    Examples
    --------
    >>> camera = Camera(4.0, K1=0.001, lens="forward")
    >>> size = dict(image_size=(4001, 3001), pixel_size=0.001)
    >>> print(exchange(camera, "colmap", **size).splitlines()[-1])
    1 OPENCV 4001 3001 4000.0 4000.0 2000.5 1500.5 0.016 0.0 0.0 0.0
    """
    _validate.choice(program, "program", PROGRAMS)
    found, (columns, rows), departure = _standard(
        camera, image_size, pixel_size, largest, skew=program == "metashape"
    )
    fx, fy, cx, cy, k1, k2, k3, p1, p2, skew = found
    about = "pgm_lab: exact"
    if departure:
        about = f"pgm_lab: fitted, departs by up to {departure:.2g} px"
    if program == "opencv":
        return _YML.format(
            about, columns, rows, [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
            [k1, k2, p1, p2, k3],
        )  # fmt: skip
    if program == "colmap":
        parameters = [fx, fy, cx + 0.5, cy + 0.5, k1, k2, p1, p2]
        model = "OPENCV"
        if k3:
            parameters += [k3, 0.0, 0.0, 0.0]
            model = "FULL_OPENCV"
        line = " ".join(map(repr, parameters))
        return (
            "# CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]\n"
            f"# {about}\n1 {model} {columns} {rows} {line}\n"
        )
    # u = w / 2 + cx + x' f + x' B1 + y' B2, v = h / 2 + cy + y' f, centres at 0.5;
    # x' = x (1 + K1 r^2 + ...) + P1 (r^2 + 2 x^2) + 2 P2 x y, y down
    fields = {
        **{"projection": "frame", "width": columns, "height": rows, "f": fy},
        **{"cx": cx + 0.5 - columns / 2, "cy": cy + 0.5 - rows / 2},
        **{"b1": fx - fy, "b2": skew, "k1": k1, "k2": k2, "k3": k3},
        **{"p1": p2, "p2": p1},
    }
    inside = "".join(f"  <{name}>{value}</{name}>\n" for name, value in fields.items())
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f"<!-- {about} -->\n<calibration>\n{inside}</calibration>\n"
    )


_YML = """%YAML:1.0
---
# {}
image_width: {}
image_height: {}
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: {}
distortion_coefficients: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: {}
"""
