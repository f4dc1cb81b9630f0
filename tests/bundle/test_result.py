"""What a result says of its unknowns."""

import numpy as np

from pgm_lab import bundle
from tests.networks import small


def test_unknowns_are_told_by_owner_and_parameter_in_the_order_of_the_covariance():
    found = bundle.adjust(small(cameras=2), ("c", "K1"))
    assert found.unknowns[:4] == (
        ("camera", 1, "c"),
        ("camera", 1, "K1"),
        ("camera", 2, "c"),
        ("camera", 2, "K1"),
    )
    assert len(found.unknowns) == len(found.covariance) == 4 + 6 * 6
    of_photo = bundle.Unknown("photo", 3, "phi")
    i = found.unknowns.index(of_photo)
    assert found.names[i] == "phi of photo 3" and found.names[2] == "c of camera 2"
    expected = np.diagonal(found.covariance_exteriors[2])[4]
    assert found.covariance[i, i] == expected


def test_the_name_of_an_only_camera_goes_without_saying():
    found = bundle.adjust(small(), ("c", "K1"))
    assert found.interior_names == ("c", "K1") and found.names[2] == "X0 of photo 1"
    assert bundle.adjust(small(), ()).names[0] == "X0 of photo 1"
