"""A camera before a bent board, rendered once: the truth, and what is measured."""

import functools

import numpy as np

from pgm_lab.calibration import Board, measure
from pgm_lab.camera import Camera
from pgm_lab.simulate import boards

SIZE, PIXEL = (480, 360), 0.01
BOARD = Board("charuco", 9, 7, 28.0, 17.0)
ESTIMATED = 8  # without b1 and b2


def lens(rng):
    """A camera like that of a phone: some 60 degrees, K1 to K3."""
    c = rng.uniform(3.6, 4.8)
    x0, y0 = 0.1 * rng.normal(size=2)
    corner = 1.05 * (np.hypot(2.4, 1.8) + np.hypot(x0, y0)) / c  # and the blur's reach
    r = np.linspace(0, 2, 100)
    fold = True
    while fold:  # where the distortion turns back before the corner of the image
        K = rng.uniform(-0.12, 0.05), rng.uniform(-0.05, 0.08), 0.02 * rng.normal()
        slope = 1 + 3 * K[0] * r**2 + 5 * K[1] * r**4 + 7 * K[2] * r**6
        reached = r + K[0] * r**3 + K[1] * r**5 + K[2] * r**7
        fold = np.any(slope[np.maximum.accumulate(reached) < corner] < 0.2)
    K = (k / c**i for k, i in zip(K, (2, 4, 6)))
    P = 5e-4 * rng.normal(size=2) / c
    return Camera(c, x0, y0, *K, *P, lens="forward")


def bent(rng, height=2.0):
    """A board bent by up to `height` mm."""
    a = rng.normal(size=5)

    def shape(X, Y):
        x, y = (X - 98) / 98, (Y - 70) / 98
        powers = x * x, x * y, y * y, x**3 / 2, x * x * y / 2
        return 1.5 * height * sum(map(np.multiply, a, powers)) / np.abs(a).sum()

    return shape


def photos(camera, shape, rng, number=10, **settings):
    """Photos from all sides, in two distances, turned; each shows most of the board."""
    taken = []
    while len(taken) < number:
        i = len(taken)
        distance = rng.uniform(0.9, 1.4) * 54 * camera.c
        azimuth = 1080 * i / number + rng.uniform(-20, 20)
        roll = 90 * (i % 4) + rng.uniform(-15, 15)
        exterior = boards.view(BOARD, distance, rng.uniform(10, 45), azimuth, roll)
        exterior[:2] += 25 * rng.normal(size=2)
        given = {"shape": shape, "noise": 2.0, "light": 0.3, "rng": rng}
        given |= {"blur": rng.uniform(0.6, 1.0)} | settings
        try:
            one = boards.photograph(BOARD, camera, exterior, SIZE, PIXEL, **given)
        except ValueError:  # a corner outside the image lies beyond the lens's fold
            continue
        if np.mean(one.inside) > 0.6:
            taken.append(one)
    return taken


def measured(taken):
    """What `measure` finds in photos."""
    return [measure(one.grey, BOARD, f"photo {i}") for i, one in enumerate(taken)]


@functools.cache
def scene():
    """Camera, photos, and what was measured in them."""
    rng = np.random.default_rng(8)
    camera = lens(rng)
    taken = photos(camera, bent(rng), rng)
    return camera, taken, measured(taken)
