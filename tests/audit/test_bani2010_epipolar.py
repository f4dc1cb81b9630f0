"""Proof of the verdict on Bani 2010, II.1.2.1: the legend of figure 2.6."""

import numpy as np
from numpy.testing import assert_allclose as close

from pgm_lab import epipolar, rotation
from pgm_lab.camera import Camera, Photo


def test_e_are_lines_of_the_plane_that_o1_and_o2_span_only_together_with_p():
    """P' and P'' lie on e' and e'', as printed; O1, O2 are stations, and no plane."""
    grey, camera = np.zeros((1296, 1936), np.uint8), Camera(35.0)
    photos = [
        Photo(grey, camera, exterior, 0.0122)
        for exterior in ((0, 0, 110, 0.03, -0.05, 0.1), (30, 4, 112, -0.06, 0.02, -0.2))
    ]
    O1, O2 = (photo.exterior[:3] for photo in photos)
    P = np.array([(10.0, 8, 3), (22, -15, 9), (5, -9, -4)])
    planes = np.cross(O2 - O1, P - O1)
    planes /= np.linalg.norm(planes, axis=1, keepdims=True)
    # The plane of the caption, through both centres and the object point
    for photo in photos:
        M = rotation.matrix(*photo.exterior[3:])
        # e is where it cuts the image plane z = -c of the photo's frame
        a, b, w = M @ planes.T
        lines = np.stack([a, b, -camera.c * w], -1)
        lines /= np.linalg.norm(lines[:, :2], axis=1, keepdims=True)
        image = photo.ideal(photo.project(P))  # P' or P''
        off = np.sum(lines[:, :2] * image, axis=1) + lines[:, 2]
        assert np.abs(off).max() < 1e-9
        # and it is the epipolar line of `epipolar`, which never saw P
        other = photos[1] if photo is photos[0] else photos[0]
        found = epipolar.line(other, photo, other.project(P))
        found *= np.sign(np.sum(found * lines, axis=1, keepdims=True))
        close(found, lines, atol=1e-9)
    # O1 and O2 lie in the planes of all points: they alone do not tell which one
    assert np.abs(planes @ (O2 - O1)).max() < 1e-12
    apart = np.degrees(np.arccos(np.abs(planes @ planes.T)[np.triu_indices(3, 1)]))
    assert apart.min() > 1
