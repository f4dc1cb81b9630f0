"""Image coordinates in another unit or frame: said first, and never of good ones."""

from dataclasses import replace

import numpy as np
import pytest

from pgm_lab import bundle, report, simulate
from pgm_lab.camera import Camera
from pgm_lab.report.network import Case, doubt
from tests.networks import jaicov_9x50, real, small


def jaicov():
    data = jaicov_9x50()
    camera = Camera(*data.interior)
    measured = data.photo, data.point, data.xy, data.sigma
    return bundle.Network(camera, data.exteriors, data.points, *measured)


def simulated(*arguments, **options):
    known = simulate.network(*arguments, np.random.default_rng(1), **options)
    measured = known.photo, known.point, known.xy, known.sigma
    return bundle.Network(known.camera, known.exteriors, known.points, *measured)


NETWORKS = {
    "2013": real,
    "JAICOV": jaicov,
    "small": small,
    "forward, two cameras": lambda: small("forward", cameras=2),
    "few photos": lambda: small(photos=2, points=8),
    "simulated": lambda: simulated(Camera(35.0, K1=-1e-4), 9, 50),
    "block": lambda: simulated(Camera(35.0), 12, 200, rays=3.4, block=True),
}


@pytest.fixture(scope="module", params=NETWORKS.values(), ids=NETWORKS.keys())
def network(request):
    return request.param()


WRONG = {
    "metres": (lambda xy: xy / 1000, "be in metres, not in millimetres"),
    "centimetres": (lambda xy: xy / 10, "be in centimetres, not in millimetres"),
    "micrometres": (lambda xy: xy * 1000, "be in pixels or micrometres"),
    "pixels": (lambda xy: xy / 0.006, "be in pixels or micrometres"),
    "pixels from a corner": (
        lambda xy: xy * [1, -1] / 0.006 + [2000, 1500],
        "be in pixels or micrometres",
    ),
    "exchanged": (lambda xy: xy[:, ::-1], "have x and y exchanged, compared"),
    "exchanged, reversed": (lambda xy: -xy[:, ::-1], "have x and y exchanged, both"),
    "y down": (lambda xy: xy * [1, -1], "count y downwards"),
    "x left": (lambda xy: xy * [-1, 1], "count x to the left"),
}


@pytest.mark.parametrize("change, words", WRONG.values(), ids=WRONG.keys())
def test_what_is_wrong_with_the_image_is_named(network, change, words):
    found = doubt(replace(network, xy=change(network.xy)))
    assert f"The image coordinates seem to {words}" in found.words


def test_good_coordinates_are_never_doubted(network):
    assert doubt(network) is None


@pytest.mark.parametrize("rough", [0.1, 0.2, 0.4, 1.0, 3.0])
def test_rough_start_values_do_not_throw_doubt_on_good_coordinates(network, rough):
    rng = np.random.default_rng(5)
    size = np.ptp(network.exteriors[:, :3])
    for _ in range(10):
        exteriors = network.exteriors.copy()
        exteriors[:, 3:] += rough * rng.normal(size=exteriors[:, 3:].shape)
        exteriors[:, :3] += 0.2 * rough * size * rng.normal(size=(len(exteriors), 3))
        assert doubt(replace(network, exteriors=exteriors)) is None


@pytest.mark.parametrize("kind", ["metres", "pixels", "exchanged", "y down"])
def test_rough_start_values_do_not_hide_it_either(kind):
    """Angles off by six degrees, stations by a tenth of their distance."""
    change, words = WRONG[kind]
    rng = np.random.default_rng(7)
    for network in (real(), jaicov(), small()):
        for _ in range(10):
            exteriors = network.exteriors.copy()
            exteriors[:, 3:] += 0.1 * rng.normal(size=exteriors[:, 3:].shape)
            exteriors[:, :3] *= 1 + 0.1 * rng.normal(size=(len(exteriors), 1))
            odd = replace(network, exteriors=exteriors, xy=change(network.xy))
            assert words in doubt(odd).words


@pytest.mark.parametrize("scale, words", [(1e-3, "be in metres"), (166.0, "be in pix")])
def test_a_network_all_in_another_unit_is_noticed_too(scale, words):
    """c, x, y, sx, sy of one unit agree with each other: only the size tells."""
    whole = real()
    camera = Camera(35.0 * scale)
    xy, sigma = scale * whole.xy, scale * whole.sigma
    odd = replace(whole, cameras=camera, xy=xy, sigma=sigma)
    assert words in doubt(odd).words


@pytest.mark.parametrize("kind", ["metres", "exchanged"])
def test_headline_and_first_finding_say_so(kind):
    """The headline was once "about 2870 times better than stated"."""
    network = real()
    change, words = WRONG[kind]
    result = bundle.adjust(replace(network, xy=change(network.xy)))
    said = Case(result).findings
    assert said[0].title == "Image coordinates" and words in said[0].words
    titles = {one.title for one in said}
    assert not {"Stated standard deviations", "Mirrored image"} & titles
    text = report.text(result, short=True).replace("\n", " ")
    headline = text.partition("1  What to look at first")[0]
    assert words in headline and "than stated" not in headline
    assert "cannot be used before this is put right" in headline
    tiny = report.text(bundle.adjust(replace(network, sigma=1e-12)), short=True)
    assert "in metres, or is the exponent wrong?" in " ".join(tiny.split())
    assert "worse than stated" not in tiny


@pytest.mark.parametrize("start, doubted", [(11.0, True), (12.0, False)])
def test_a_principal_distance_far_from_its_start_value_is_named(start, doubted):
    """Start values too rough to judge the image by: what c becomes still tells."""
    result = bundle.adjust(real())
    camera = replace(result.network.cameras[0], c=start)
    exteriors = result.network.exteriors.copy()
    exteriors[:, 3:] += 1.0
    network = replace(result.network, cameras=camera, exteriors=exteriors)
    found = replace(result, network=network)
    assert (Case(found).changed_c is not None) == doubted
    said = dict(Case(found).findings).get("Principal distance", "")
    assert (f"34.6 mm from a start value of {start:.0f}" in said) == doubted
