"""Interpolation fine enough for least squares matching: the image on a doubled grid.

The error of a cubic spline grows with the fourth power of the frequency. On a grid of
half pixels every frequency is half as high, so it is a sixteenth; a windowed sinc, good
to 0.42 cycles a pixel, finds the grey values between the pixels. Both steps are linear
and the same everywhere: together they are two short filters.
"""

import functools

import cv2
import numpy as np
import scipy

RADIUS = 8  # pixels to each side that a coefficient depends on
KAISER_BETA = 7.0  # shape of the Kaiser window over the sinc
BORDER = cv2.BORDER_REFLECT_101


def coefficients(image: np.ndarray) -> np.ndarray:
    """Coefficients (2 rows, 2 columns) of a cubic spline on a grid of half pixels."""
    # In single precision, a ten millionth of the contrast: subtract the mean
    image = image.astype(np.float32)
    across = cv2.merge([_filter(image, kernel[None]) for kernel in kernels()])
    across = across.reshape(len(image), -1)  # pixel, half, pixel, half, ...
    both = np.empty((2 * len(image), across.shape[1]), np.float32)
    for half, kernel in enumerate(kernels()):
        both[half::2] = _filter(across, kernel[:, None])
    return both


def inner_coefficients(parts: np.ndarray) -> np.ndarray:
    """Coefficients of parts (m, size, size), but for `RADIUS` pixels at each edge."""
    # By products with a matrix, quicker for many; what depends on a NaN is NaN
    size = parts.shape[1]
    inner = np.arange(size - 2 * RADIUS)
    K = np.zeros((2 * len(inner), size), np.float32)
    for half, kernel in enumerate(kernels()):
        for i, weight in enumerate(kernel):
            K[2 * inner + half, inner + half + i] = weight
    holes = np.isnan(parts)
    some = np.flatnonzero(holes.any(axis=(1, 2)))
    found = K @ (np.where(holes, np.float32(0), parts) if len(some) else parts) @ K.T
    touches = (K != 0).astype(np.float32)
    touched = touches @ holes[some].astype(np.float32) @ touches.T > 0
    found[some] = np.where(touched, np.float32(np.nan), found[some])
    return found


def sample(fine: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Grey values at columns x and rows y of the image, from its coefficients."""
    at = np.array([2 * y.ravel(), 2 * x.ravel()])
    found = scipy.ndimage.map_coordinates(
        fine, at, output=float, order=3, mode="mirror", prefilter=False
    )
    return found.reshape(x.shape)


def sample_gradient(fine: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Derivatives (2, ...) of `sample`, as (B 2.12), (B 2.13) but with short steps."""
    h = 1e-3  # px: then the third derivative adds a millionth
    across = sample(fine, x + h, y) - sample(fine, x - h, y)
    down = sample(fine, x, y + h) - sample(fine, x, y - h)
    return np.array([across, down]) / (2 * h)


def gradient(image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives by x and y of the quintic spline through the pixels, at them."""
    image = image.astype(np.float32)
    kernel = derivative_kernel()
    return _filter(image, kernel[None]), _filter(image, kernel[:, None])


def noise_gain(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Variance of an interpolated grey value relative to a pixel's, for white noise."""
    values = gain()
    at = np.linspace(0, 1, len(values))
    return np.interp(x % 1, at, values) * np.interp(y % 1, at, values)


def derivative_gain(smooth: float) -> float:
    """Variance of `gradient` relative to a pixel's, for noise under a Gaussian."""
    kernel = derivative_kernel()
    if not smooth:
        return float(kernel @ kernel)
    reach = np.arange(-np.ceil(4 * smooth), np.ceil(4 * smooth) + 1)
    gauss = np.exp(-(reach**2) / (2 * smooth**2))
    both = np.convolve(kernel, gauss)
    return float(both @ both / (gauss @ gauss))


def _filter(image: np.ndarray, kernel: np.ndarray) -> np.ndarray:
    # An even kernel finds the value half a pixel after its anchor
    rows, columns = kernel.shape
    anchor = (columns - 1) // 2, (rows - 1) // 2
    return cv2.filter2D(image, -1, kernel, anchor=anchor, borderType=BORDER)


@functools.cache
def kernels() -> tuple[np.ndarray, np.ndarray]:
    """Filters for the coefficients on the pixels, and on the halves after them."""
    halves = np.arange(-RADIUS, RADIUS) + 0.5
    sinc = np.sinc(halves) * np.i0(KAISER_BETA * np.sqrt(1 - (halves / RADIUS) ** 2))
    doubled = np.zeros(4 * RADIUS + 1)
    doubled[2 * RADIUS] = 1
    doubled[1::2] = sinc / sinc.sum()
    spline = scipy.ndimage.spline_filter1d(np.pad(doubled, 40), 3, mode="mirror")
    middle = len(spline) // 2
    on = spline[middle - 2 * RADIUS : middle + 2 * RADIUS + 1 : 2]
    between = spline[middle - 2 * RADIUS + 1 : middle + 2 * RADIUS : 2]
    return on / on.sum(), between / between.sum()


@functools.cache
def derivative_kernel() -> np.ndarray:
    """Filter that differentiates the quintic spline through the pixels, at them."""
    # It loses what lies above 0.35 cycles a pixel, which in real images is noise
    impulse = np.zeros(33)
    impulse[16] = 1
    spline = scipy.ndimage.spline_filter1d(impulse, 5, mode="mirror")
    response = np.convolve(spline, np.array([1, 10, 0, -10, -1]) / 24, mode="same")
    return response[16 - RADIUS : 17 + RADIUS][::-1].copy()


@functools.cache
def gain(steps: int = 32) -> np.ndarray:
    """Sum of the squared weights of the pixels at 0, 1/steps, ..., 1 px after one."""
    n = 4 * RADIUS + 1
    impulse = np.zeros((1, n))
    impulse[0, n // 2] = 1
    spline = np.zeros(2 * n)
    spline[0::2] = _filter(impulse, kernels()[0][None])[0]
    spline[1::2] = _filter(impulse, kernels()[1][None])[0]
    x = np.arange(RADIUS, n - RADIUS - 1)[:, None] + np.linspace(0, 1, steps + 1)
    weights = scipy.ndimage.map_coordinates(spline, [2 * x], order=3, prefilter=False)
    return (weights**2).sum(axis=0)
