"""What the program says of a point."""

import numpy as np

from pgm_lab import stereo_map
from pgm_lab.stereo_map import drawing


def test_a_click_at_the_edge_was_not_sought(oriented):
    lines = drawing.lines(oriented, stereo_map.measure(oriented, (0, 0)))
    assert "Too near to the edge" in lines[0] and "Sought" not in lines[0]


def test_the_base_of_a_model_has_its_sign(unknown):
    model = stereo_map.orient(unknown)
    assert "Model (base in x: 1): X" in drawing.lines(model, model.points[0])[-1]
    swapped = stereo_map.open_pair(unknown.right, unknown.left)
    for point in unknown.points:
        place = np.round(point.right)
        found = stereo_map.measure(swapped, place, point.left, reach=6)
        if found.accepted:
            swapped = stereo_map.add(swapped, found)
    model = stereo_map.orient(swapped)
    assert model.right.exterior[0] == -1
    assert "Model (base in x: −1): X" in drawing.lines(model, model.points[0])[-1]
