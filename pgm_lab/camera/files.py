"""A calibrated camera as a file: camera.json, and the files of other programs.

camera.json states its convention in words, the ten parameters with their standard
deviations and covariance, and the image they belong to; `read` gives back each bit.

OpenCV, COLMAP and Metashape have the lens model of lens="forward" without b1 and b2,
in units of c, with y down, and convert exactly: k_i = K_i c^(2i), p1 = -P2 c,
p2 = P1 c. Another camera is fitted to theirs by least squares over the image. The
largest departure that is left stands in the file; one above `LARGEST` is refused.
"""

import os
from collections.abc import Callable, Sequence

import cv2
import numpy as np
import scipy
from numpy.typing import ArrayLike

from pgm_lab import _validate, frames
from pgm_lab.camera import _document, imaging
from pgm_lab.camera._document import CameraFile
from pgm_lab.camera.model import PARAMETERS, Camera, ideal
from pgm_lab.io.files import printable

LARGEST = 0.1  # px, about the uncertainty of a ray after a good calibration
PROGRAMS = ("opencv", "colmap", "metashape")
GRID = 25  # places a side, from edge to edge, on which models are compared


def read(path: str | os.PathLike) -> CameraFile:
    """Read a camera.json.

    Raises ValueError, with what is wrong, if it is damaged, contradicts itself or has
    another convention; OSError if it cannot be read.
    """
    return _document.read(path, Camera)


def of_photo(
    camera: Camera | str | os.PathLike,
    image_size: Sequence[int],
    pixel_size: float | None = None,
    photo: str = "photo",
    held: int = 1,
) -> tuple[Camera, float | None]:
    """Camera and pixel size of a photo, from a camera.json if `camera` is its path.

    `held` is the orientation in the photo's EXIF, by which it was turned upright. What
    does not fit the file, or does not lie as on the sensor, raises ValueError.
    """
    if not isinstance(camera, str | os.PathLike):
        return _validate.instance(camera, Camera, "camera"), pixel_size
    found, file = read(camera), printable(camera)
    size = tuple(int(n) for n in image_size)
    if held != 1 or size != found.image_size:
        has, wanted = (f"{one[0]} x {one[1]}" for one in (size, found.image_size))
        raise ValueError(
            f"{photo} has {has} pixels, and the camera of {file} {wanted}, as they lie"
            " on the sensor: was it turned upright by its EXIF, reduced or cropped?"
        )
    if pixel_size not in (None, found.pixel_size):
        given = f"pixel_size is {pixel_size}, {file} has {found.pixel_size} mm"
        raise ValueError(f"{given}: leave it out")
    return found.camera, found.pixel_size


# --- Other programs ---


def to_opencv(file: CameraFile) -> tuple[np.ndarray, np.ndarray, float]:
    """Convert a camera to OpenCV's model: exactly, or by least squares over the image.

    Exact is lens="forward" without b1 and b2. Fitted, fx and fy differ for b1; there is
    nothing for b2, the shear.

    Returns
    -------
    matrix : ndarray (3, 3)
        fx, fy, cx, cy in pixels, whole numbers at pixel centres.
    distortion : ndarray (5,)
        k1, k2, p1, p2, k3.
    departure : float
        From the camera, in pixels, at most over the image; 0 if it converts exactly.

    Examples
    --------
    >>> camera = Camera(4.0, K1=0.001, lens="forward")
    >>> K, distortion, departure = to_opencv(CameraFile(camera, (4001, 3001), 0.001))
    >>> K[0], distortion, departure
    (array([4000.,    0., 2000.]), array([0.016, 0.   , 0.   , 0.   , 0.   ]), 0.0)
    """
    camera = _validate.instance(file, CameraFile, "file").camera
    image = file.image_size, file.pixel_size
    c, departure = camera.c, 0.0
    fx = fy = c / file.pixel_size
    centre = frames.photo_to_pixel((camera.x0, camera.y0), *image)
    k1, k2, k3 = camera.K1 * c**2, camera.K2 * c**4, camera.K3 * c**6
    p1, p2 = 0 - camera.P2 * c, camera.P1 * c  # not -0
    found = np.array([fx, fy, *centre, k1, k2, p1, p2, k3])
    if camera.lens == "backward" or camera.b1 or camera.b2:
        pixels = _grid(*file.image_size)
        rays = ideal(camera, frames.pixel_to_photo(pixels, *image)) / (c, -c)  # y down

        def residuals(p: np.ndarray) -> np.ndarray:
            k1, k2, p1, p2, k3 = p[4:]
            lens = np.array([k1, k2, k3, p2, p1, 0, 0])
            return (rays + imaging.distortion(lens, rays)) * p[:2] + p[2:4] - pixels

        found, departure = _fit(residuals, found, "b1, b2 or lens='backward'")
    fx, fy, cx, cy = found[:4]
    return np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]]), found[4:], departure


def from_opencv(
    matrix: ArrayLike,
    distortion: ArrayLike,
    image_size: ArrayLike,
    pixel_size: float,
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

    Examples
    --------
    >>> K = [[4000, 0, 2000], [0, 4000, 1500], [0, 0, 1]]
    >>> from_opencv(K, [0.016, 0, 0, 0], (4001, 3001), 0.001).K1
    0.001
    """
    K = _validate.of_shape(matrix, (3, 3), "matrix")
    fx, fy, cx, cy = K[0, 0], K[1, 1], *K[:2, 2]
    if min(fx, fy) <= 0 or np.any(K != [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]):
        raise ValueError("matrix must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], fx > 0")
    d = _validate.finite(distortion, "distortion").ravel()
    if d.size not in (0, 4, 5, 8, 12, 14):
        raise ValueError(f"distortion must be 0, 4, 5, 8, 12 or 14 numbers: {d.size}")
    columns, rows = (int(n) for n in _validate.image_size(image_size))
    size = _validate.positive_number(pixel_size, "pixel_size", "mm")
    c = fy * size
    centre = frames.pixel_to_photo((cx, cy), (columns, rows), size, False)
    k1, k2, p1, p2, k3 = [*d, 0, 0, 0, 0, 0][:5]
    lens = k1 / c**2, k2 / c**4, k3 / c**6, p2 / c, 0 - p1 / c
    found = np.array([c, *centre, *lens, fx / fy - 1, 0])
    if fx != fy or np.any(d[5:]):
        pixels = _grid(columns, rows)[:, None]
        rays = cv2.undistortPoints(pixels, K, d)
        ahead, still = cv2.convertPointsToHomogeneous(rays), np.zeros(3)
        seen = np.asarray(cv2.projectPoints(ahead, still, still, K, d)[0])
        photo = frames.pixel_to_photo(seen, (columns, rows), size, False)

        def residuals(p: np.ndarray) -> np.ndarray:
            at = rays * (p[0], -p[0])
            return (at + imaging.distortion(p[3:], at) + p[1:3] - photo)[:, 0] / size

        found, _ = _fit(residuals, found, "coefficients beyond k3 and two scales")
    return Camera(**dict(zip(PARAMETERS, found.tolist())), lens="forward")


def _grid(columns: int, rows: int) -> np.ndarray:
    """Pixels (n, 2) all over an image, from edge to edge."""
    sides = (np.linspace(-0.5, n - 0.5, GRID) for n in (columns, rows))
    return np.stack(np.meshgrid(*sides), -1).reshape(-1, 2)


def _fit(
    residuals: Callable[[np.ndarray], np.ndarray], start: np.ndarray, missing: str
) -> tuple[np.ndarray, float]:
    """Parameters with the least residuals (n, 2), in pixels, and the largest one."""
    limits = dict.fromkeys(("xtol", "ftol", "gtol"), 1e-15)
    solved = scipy.optimize.least_squares(
        lambda p: residuals(p).ravel(), start, x_scale="jac", **limits
    )
    p = solved.x
    departure = float(np.hypot(*residuals(p).T).max())
    if not departure <= LARGEST:
        raise ValueError(
            f"the other lens model has no {missing}: fitted to it, the camera departs"
            f" by up to {departure:.3g} px in the image, and the limit is {LARGEST}"
        )
    return p, departure


def exchange(file: CameraFile, program: str) -> str:
    """Return the text of a file with the camera for another program.

    Parameters
    ----------
    file : CameraFile
    program : {"opencv", "colmap", "metashape"}
        "opencv": a .yml for `cv2.FileStorage`, with image_width, image_height,
        camera_matrix, distortion_coefficients. "colmap": a cameras.txt with camera 1,
        as OPENCV, or FULL_OPENCV if there is a k3; its pixel centres lie at 0.5.
        "metashape": an .xml for Tools > Camera Calibration > Load, by the formula and
        the fields of Agisoft's manual; it was not tried in the program itself.

    Examples
    --------
    >>> camera = Camera(4.0, K1=0.001, lens="forward")
    >>> text = exchange(CameraFile(camera, (4001, 3001), 0.001), "colmap")
    >>> print(text.splitlines()[-1])
    1 OPENCV 4001 3001 4000.0 4000.0 2000.5 1500.5 0.016 0.0 0.0 0.0
    """
    _validate.choice(program, "program", PROGRAMS)
    K, distortion, departure = to_opencv(file)
    about = f"pgm_lab: departs from the camera by up to {departure:.2g} px"
    columns, rows = file.image_size
    if program == "opencv":
        yml = cv2.FileStorage(".yml", cv2.FILE_STORAGE_WRITE | cv2.FILE_STORAGE_MEMORY)
        yml.writeComment(about)
        yml.write("image_width", columns)
        yml.write("image_height", rows)
        yml.write("camera_matrix", K)
        yml.write("distortion_coefficients", distortion[None])
        return yml.releaseAndGetString()
    (fx, _, cx), (_, fy, cy), _ = K.tolist()
    k1, k2, p1, p2, k3 = distortion.tolist()
    if program == "colmap":
        model, more = ("FULL_OPENCV", [k3, 0.0, 0.0, 0.0]) if k3 else ("OPENCV", [])
        numbers = [fx, fy, cx + 0.5, cy + 0.5, k1, k2, p1, p2, *more]
        return (
            f"# CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]\n# {about}\n"
            f"1 {model} {columns} {rows} {' '.join(map(str, numbers))}\n"
        )
    # u = w / 2 + cx + x' f + x' B1 + y' B2, v = h / 2 + cy + y' f, centres at 0.5;
    # x' = x (1 + K1 r^2 + ...) + P1 (r^2 + 2 x^2) + 2 P2 x y, y down
    fields = {
        **{"projection": "frame", "width": columns, "height": rows, "f": fy},
        **{"cx": cx + 0.5 - columns / 2, "cy": cy + 0.5 - rows / 2},
        **{"b1": fx - fy, "b2": 0.0, "k1": k1, "k2": k2, "k3": k3, "p1": p2, "p2": p1},
    }
    inside = "".join(f"  <{name}>{value}</{name}>\n" for name, value in fields.items())
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f"<!-- {about} -->\n<calibration>\n{inside}</calibration>\n"
    )
