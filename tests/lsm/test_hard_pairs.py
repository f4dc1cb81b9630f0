"""Real texture, turned, scaled or aliased, from starts that know the place alone.

The orthophoto is warped by OpenCV, which makes the truth known to some hundredths of a
pixel. OpenCV's ECC has the same windows and starts.
"""

import cv2
import numpy as np
import pytest

from pgm_lab import datasets, lsm

HALF, ROOM = 10, 32


def corners(image, n=80, seed=1):
    """Whole pixels (n, 2) whose windows have texture, 10 px apart or more."""
    strength = cv2.cornerMinEigenVal(image.astype(np.float32), 2 * HALF + 1, 3)
    strength[:ROOM] = strength[-ROOM:] = 0
    strength[:, :ROOM] = strength[:, -ROOM:] = 0
    row, column = np.nonzero(strength > np.quantile(strength, 0.6))
    found = []
    for i in np.random.default_rng(seed).permutation(len(row)):
        at = np.array([column[i], row[i]], float)
        if all(np.abs(at - other).max() >= 10 for other in found):
            found.append(at)
        if len(found) == n:
            break
    return np.array(found)


def warped(left, degrees, scale, noise=2.0, size=0.0):
    """Left and right image with noise; points and where they are in the right image."""
    c, s = scale * np.cos(np.radians(degrees)), scale * np.sin(np.radians(degrees))
    A = np.array([[c, -s], [s, c]])
    middle = np.array(left.shape[::-1]) / 2
    t = middle - A @ middle + (0.37, -0.21)
    right = cv2.warpAffine(
        left.astype(np.float32),
        np.column_stack([A, t]),
        left.shape[::-1],
        flags=cv2.INTER_CUBIC,
        borderMode=cv2.BORDER_REFLECT,
    )
    rng = np.random.default_rng(0)
    images = [
        np.clip(image + rng.normal(0, noise, image.shape), 0, 255).round()
        for image in (left, right)
    ]
    points = corners(images[0])
    truth = points @ A.T + t
    inside = np.all((truth > ROOM) & (truth < 2 * middle - ROOM), axis=1)
    return *(image.astype(np.uint8) for image in images), points[inside], truth[inside]


def ecc(left, right, points, start, room=12):
    """Matches by cv2.findTransformECC in cut-outs: NaN where it gives up."""
    criteria = cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 50, 1e-5
    found = np.full(points.shape, np.nan)
    for i, ((x, y), (u, v)) in enumerate(zip(points.astype(int), start.astype(int))):
        template = left[y - HALF : y + HALF + 1, x - HALF : x + HALF + 1]
        far = HALF + room
        part = right[v - far : v + far + 1, u - far : u + far + 1]
        T = np.array([[1, 0, room], [0, 1, room]], dtype=np.float32)
        try:
            _, T = cv2.findTransformECC(
                template, part, T, cv2.MOTION_AFFINE, criteria, None, 5
            )
        except cv2.error:
            continue
        found[i] = T @ [HALF, HALF, 1] + [u - far, v - far]
    return found


def shares(points, truth):
    """Shares that were found to half a pixel, and that are wrong by more than one."""
    error = np.hypot(*(points - truth).T)
    return np.mean(error < 0.5), np.mean(error > 1)


@pytest.fixture(scope="module")
def ground():
    """The orthophoto, halved."""
    grey = datasets.yellowstone().grey
    return cv2.resize(grey, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)


@pytest.mark.parametrize(
    ("degrees", "scale", "least"), [(15, 1.0, 0.9), (0, 0.85, 0.95), (10, 1.2, 0.9)]
)
def test_turned_and_scaled_images_are_matched_as_often_as_by_ecc(
    ground, degrees, scale, least
):
    left, right, points, truth = warped(ground[:400, :400], degrees, scale)
    assert len(points) >= 50
    start = truth.round()
    found = lsm.match(left, right, points, start)
    good, wrong = shares(found.points, truth)
    theirs, their_wrong = shares(ecc(left, right, points, start), truth)
    assert good >= max(least * theirs, 0.95)
    assert wrong <= max(their_wrong, 1 / len(points))


def aerial_pair(grey, step, blur_left=0.0, blur_right=0.0):
    """Photos with pixels `step` times as large and aliased, turned by four degrees.

    Points, where they are in the right image, and the shape of their windows there.
    """
    size = grey.shape[0] // step - 20
    row, column = np.mgrid[:size, :size].astype(float)
    c, s = np.cos(np.radians(4)), np.sin(np.radians(4))
    middle, shape = size / 2, np.array([[c, s], [-s, c]])
    x, y = column - middle, row - middle
    there = (c * x - s * y + middle + 0.37, s * x + c * y + middle - 0.21)
    images = []
    for (u, v), blur in (((column, row), blur_left), (there, blur_right)):
        u, v = ((a * step + 5).astype(np.float32) for a in (u, v))
        image = cv2.remap(
            grey.astype(np.float32),
            u,
            v,
            cv2.INTER_CUBIC,
            borderMode=cv2.BORDER_REFLECT,
        )
        images.append(cv2.GaussianBlur(image, (0, 0), blur) if blur else image)
    points = corners(images[0], 100)
    truth = (points - middle - (0.37, -0.21)) @ shape.T + middle
    inside = np.all((truth > ROOM) & (truth < size - ROOM), axis=1)
    return *images, points[inside], truth[inside], shape


@pytest.mark.parametrize(
    ("step", "blur", "least"),
    [
        pytest.param(3, (0, 0), 0.98, id="aliased"),
        pytest.param(2, (0, 0.7), 0.98, id="right softer"),
        pytest.param(
            *(3, (0, 1.0), 0.9), id="aliased left, soft right", marks=pytest.mark.slow
        ),
    ],
)
def test_aliased_images_are_matched_wherever_they_are_alike(step, blur, least):
    """Derivatives of a sharper or aliased left image overrate what a step changes.

    With them alone up to three quarters of the points end as "not converged".
    What lies above the threshold when it starts from the truth is what can be found.
    """
    grey = datasets.yellowstone().grey
    left, right, points, truth, shape = aerial_pair(grey, step, *blur)
    best = lsm.match(left, right, points, truth, shape=shape, max_iterations=200)
    can = best.accepted & (np.hypot(*(best.points - truth).T) < 0.5)
    assert can.sum() > 20
    found = lsm.match(left, right, points[can], truth[can].round())
    good, wrong = shares(found.points, truth[can])
    assert good >= least
    assert wrong == 0
