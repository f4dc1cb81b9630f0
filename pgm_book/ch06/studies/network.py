"""The simulated networks of `size` and of the comparison with pycolmap."""

import numpy as np

from pgm_lab import bundle, camera, simulate

# What COLMAP's camera model OPENCV estimates: fx, fy, cx, cy, k1, k2, p1, p2
ESTIMATE = ("c", "x0", "y0", "K1", "K2", "P1", "P2", "b1")
LENS = camera.Camera(
    35.0, 0.05, -0.08, K1=-8e-5, K2=6e-8, P1=4e-6, P2=-6e-6, lens="forward"
)


def network(photos, points, rays, block):
    """Simulated; the start values are wrong by 5 mm in 2 m and by 0.1 degrees."""
    rng = np.random.default_rng(6)
    net = simulate.network(LENS, photos, points, rng, rays, block=block)
    aside = rng.normal(size=(photos, 6)) * [5, 5, 5, 0.002, 0.002, 0.002]
    return bundle.Network(
        camera.Camera(35.3, lens="forward"),
        net.exteriors + aside,
        net.points + 5 * rng.normal(size=(points, 3)),
        net.photo,
        net.point,
        net.xy,
        net.sigma,
    )
