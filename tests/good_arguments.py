"""Good arguments of the public functions, small, so that bad ones can be made of them.

A function that is missing here fails `test_bad_input`. What has a default that is not
None needs no entry.
"""

from functools import cache

import numpy as np

from pgm_lab import (
    bundle,
    camera,
    datasets,
    image,
    lsm,
    ncc,
    orientation,
    registration,
    simulate,
    stereo,
)
from pgm_lab.adjustment import adjust

LENS = camera.Camera(35.0, 0.1, -0.1, K1=1e-5)
PHOTO = (10.0, 5.0, 100.0, 0.02, -0.01, 0.3)
NEXT = (30.0, 6.0, 101.0, -0.02, 0.01, 0.2)
POINTS = np.array([(20.0, 2, 4), (12, 9, 8), (3, 14, -6), (25, -8, 1), (14, 4, -9)])
UP = np.array([(0.0, 0), (1, 0), (0, 1), (1, 1), (2, 1)])
GREY = simulate.grey_values(
    simulate.texture(seed=1), np.stack(np.meshgrid(np.arange(48), np.arange(44)), -1)
)
ORTHO = datasets.yellowstone().grey[:60, :60].astype(float)
CHOSEN = np.array([(20.0, 20.0), (26, 22)])
ONE_MATRIX = {"M": np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])}
ANGLES = {"omega": 0.5, "phi": 0.25, "kappa": -0.5}
IMAGE = {"image_size": (40, 30), "pixel_size": 0.5}
BOTH = {"left": GREY, "right": GREY, "points": CHOSEN}
CHIP = {"reference": GREY, "sensed": GREY, "point": (20.0, 20), "chip": 9}
RAYS = {"left_rays": [(1.0, 2, -35)], "right_rays": [(-6.0, 2, -35)]}
PAIR = {"left_exterior": PHOTO, "right_exterior": NEXT}
COVARIANCE = np.tile(np.eye(2), (5, 1, 1))


def projected(exterior, lens=LENS):
    return camera.project(lens, exterior, POINTS)


# --- A network ---


@cache
def net():
    return simulate.network(LENS, 4, 12, np.random.default_rng(1))


@cache
def network():
    n = net()
    return bundle.Network(n.camera, n.exteriors, n.points, n.photo, n.point, n.xy)


@cache
def adjusted():
    return bundle.adjust(network(), ("c", "K1"))


def in_network():
    n = net()
    return dict(
        cameras=n.camera,
        exteriors=n.exteriors,
        points=n.points,
        photo=n.photo,
        point=n.point,
        xy=n.xy,
        sigma=np.full(2, 0.002),
        camera=np.zeros(4, int),
        fixed=np.array([3]),
        control=(np.array([0, 1]), n.points[:2], np.full((2, 3), 0.5)),
        check=(np.array([2]), n.points[2:3]),
        datum_points=np.array([4, 5, 6]),
        scale_bars=np.array([(7.0, 8, 120, 0.5)]),
        photo_names=("a", "b", "c", "d"),
        point_names=tuple("abcdefghijkl"),
        covariance=None,
    )


def tables():
    n = net()
    rows = zip(n.photo.tolist(), n.point.tolist(), *n.xy.T.tolist())
    return dict(
        cameras={"k": LENS},
        photos={i: tuple(e) for i, e in enumerate(n.exteriors.tolist())},
        points={i: tuple(p) for i, p in enumerate(n.points.tolist())},
        observations=list(rows),
        camera={i: "k" for i in range(4)},
        fixed=[3],
        control={0: (*n.points[0].tolist(), 0.5, 0.5, 0.5)},
        check={2: tuple(n.points[2].tolist())},
        datum_points=[4, 5, 6],
        scale_bars=[(7, 8, 120.0, 0.5)],
    )


# --- Matches, photos, pairs ---


@cache
def matches():
    found = ncc.match(GREY, GREY, CHOSEN, template=11, search=21)
    return {"B": lsm.match(GREY, GREY, CHOSEN, found.points, template=11)}


@cache
def registered():
    return registration.register(GREY, GREY, CHOSEN, chip=11, refine="lsm")


def raster():
    transform = np.array([[2.0, 0, 100], [0, -2, 500]])
    return registration.Raster(GREY, np.zeros(GREY.shape, bool), transform)


def oriented():
    return camera.Photo(GREY, LENS, PHOTO, 0.005)


@cache
def oriented_pair():
    left, right = (camera.Photo(GREY, LENS, one, 0.5) for one in (PHOTO, NEXT))
    return {"left": left, "right": right}


@cache
def epipolar_pair():
    return stereo.epipolar_pair(**oriented_pair(), heights=(0, 5))


def normal_pair():
    origin = np.array([(2.0, 0.0), (-4.0, 0.0)])
    stations = np.array([(0.0, 0, 1000), (400.0, 0, 1000)])
    return stereo.NormalPair(ORTHO, ORTHO, np.eye(3), stations, 24.0, 0.005, origin)


def dense_match():
    d = np.random.default_rng(3).normal(0, 5, ORTHO.shape).astype(np.float32)
    known = np.ones(d.shape, np.float32)
    return stereo.DenseMatch(d, 0.9 * known, 0.3 * known, np.zeros(d.shape, np.uint8))


def hilly_surface():
    z = np.tile(np.linspace(0.0, 3, 30), (30, 1))
    z[10:16, 12:18] += 6.0
    return stereo.Surface(z, (0.0, 15.0), 0.5, np.ones(z.shape, bool))


def level_land():
    flat = np.full((40, 40), 20.0, np.float32)
    return simulate.Landscape(flat, flat, flat, flat, (-200.0, 200.0), 10.0)


@cache
def similarity():
    return orientation.absolute(POINTS, 2 * POINTS + 7 + UP[:, :1] / 8)


@cache
def relative_pair():
    lens = camera.Camera(35.0)
    truth, left, right = simulate.pair(lens, 8, np.random.default_rng(1))
    points = {"left_points": left, "right_points": right, "start": truth[1:]}
    return points | {"camera_left": lens, "camera_right": lens}


# --- An adjustment ---


def line_fit(**more):
    at = np.array([0.0, 1, 2, 3])

    def line(x, at):
        A = np.stack([np.ones_like(at), at], axis=-1)
        return A @ x, A

    observed = np.array([0.5, 1.5, 2.6, 3.4])
    given = dict(function=line, start=np.zeros(2), observations=observed, args=(at,))
    return given | more


def to_one(x, at):
    """A condition between the unknowns of a line: they add up to 1.5."""
    return np.array([x.sum() - 1.5]), np.ones((1, 2))


FUNCTIONS = {
    "adjustment.adjust": lambda: line_fit(
        weights=np.ones(4), parameter_weights=np.ones(2), parameter_values=np.zeros(2),
        covariance=None, sigma0_prior=1.0, constraints=to_one, names=["a", "b"],
    ),
    "adjustment.Adjustment.global_test": lambda: dict(
        self=adjust(**line_fit(sigma0_prior=1.0))
    ),
    "adjustment.critical_tau": lambda: dict(redundancy=20),
    "adjustment.critical_w": dict,
    "bundle.adjust": lambda: dict(
        network=network(), estimate=("c",), datum="inner", sigma0_prior=1.0
    ),
    "bundle.correlations": lambda: dict(result=adjusted()),
    "bundle.critical_value": lambda: dict(result=adjusted()),
    "bundle.motions": lambda: dict(positions=POINTS),
    "bundle.reliability": lambda: dict(result=adjusted()),
    "bundle.significance": lambda: dict(result=adjusted()),
    "bundle.snoop": lambda: dict(
        network=network(), estimate=("c",), datum="inner", sigma0_prior=1.0
    ),
    "bundle.Network": in_network,
    "bundle.Network.of": tables,
    "bundle.Network.without": lambda: dict(self=network(), rays=[0, 1]),
    "bundle.Network.only": lambda: dict(self=network(), photos=[0, 1, 2]),
    "camera.Camera": lambda: dict(c=35.0),
    "camera.Photo": lambda: dict(
        grey=GREY, camera=LENS, exterior=PHOTO, pixel_size=0.5, image_size=(60, 50),
        corner=(2, 3), crs="EPSG:32748",
    ),
    "camera.Photo.to_photo": lambda: dict(self=oriented(), pixels=UP),
    "camera.Photo.to_pixel": lambda: dict(self=oriented(), photo=UP),
    "camera.Photo.ideal": lambda: dict(self=oriented(), pixels=UP),
    "camera.Photo.without_lens": lambda: dict(self=oriented(), pixels=UP),
    "camera.Photo.rays": lambda: dict(self=oriented(), pixels=UP),
    "camera.Photo.of_rays": lambda: dict(
        self=oriented(), directions=oriented().rays(UP)
    ),
    "camera.Photo.seen_at": lambda: dict(
        self=oriented(), directions=oriented().rays(UP)
    ),
    "camera.Photo.project": lambda: dict(self=oriented(), points=POINTS),
    "camera.Photo.outline": lambda: dict(self=oriented(), n=4),
    "camera.collinearity": lambda: dict(
        camera=LENS, exterior=PHOTO, points=POINTS, measured=UP
    ),
    "camera.ideal": lambda: dict(camera=LENS, measured=UP),
    "camera.measured": lambda: dict(camera=LENS, ideal=UP),
    "camera.project": lambda: dict(camera=LENS, exterior=PHOTO, points=POINTS),
    "epipolar.curve": lambda: oriented_pair() | dict(
        pixel=(20.0, 20), heights=[0.0, 5], depths=None
    ),
    "epipolar.distance": lambda: oriented_pair() | dict(
        left_pixels=UP, right_pixels=UP
    ),
    "epipolar.epipole": oriented_pair,
    "epipolar.essential": lambda: PAIR,
    "epipolar.fundamental": lambda: oriented_pair() | dict(corrected=True),
    "epipolar.line": lambda: oriented_pair() | dict(pixels=UP),
    "epipolar.plane": lambda: oriented_pair() | dict(pixels=UP),
    "frames.image_centre": lambda: dict(image_size=(40, 30)),
    "frames.pixel_to_photo": lambda: dict(pixels=UP, **IMAGE, covariance=COVARIANCE),
    "frames.photo_to_pixel": lambda: dict(photo=UP, **IMAGE, covariance=COVARIANCE),
    "frames.pixel_size_from_sensor": lambda: dict(
        sensor_size=(24.0, 18.0), image_size=(40, 30)
    ),
    "frames.interior_matrix": lambda: dict(c=35.0),
    "frames.scale_number": lambda: dict(flying_height=110.0, principal_distance=24.0),
    "frames.ground_sampling_distance": lambda: dict(
        pixel_size=0.5, flying_height=110.0, principal_distance=24.0
    ),
    "frames.flying_height": lambda: dict(
        gsd=20.0, pixel_size=0.5, principal_distance=24.0
    ),
    "image.centroid": lambda: dict(
        window=simulate.target((10.25, 9.5), diameter=8), background=40.0, sigma=1.0
    ),
    "image.statistics": lambda: dict(image=GREY),
    "image.histogram": lambda: dict(image=GREY.round().astype(np.uint8)),
    "image.equalize": lambda: dict(image=GREY.round().astype(np.uint8)),
    "image.gradient": lambda: dict(image=GREY),
    "image.pyramid": lambda: dict(image=GREY, levels=2),
    "image.resample": lambda: dict(image=GREY, points=[(3.5, 4), (5, 6)], outside=1.0),
    "image.cut": lambda: dict(image=GREY, centre=(20.0, 20), size=5),
    "lsm.match": lambda: BOTH | dict(start=CHOSEN, template=11, shape=np.eye(2)),
    "lsm.adjust": lambda: BOTH | dict(
        points=[(20.0, 20)], parameters=[(20.25, 1, 0, 20, 0, 1, 0, 1)], template=11
    ),
    "lsm.cramer_rao": lambda: dict(
        grey=GREY[:11, :11], sigma=1.0, shape=np.eye(2),
        gradients=np.stack(image.gradient(GREY), -1)[:11, :11],
    ),
    "matching.match": lambda: BOTH | dict(
        start=CHOSEN, shape=np.eye(2), template=11, search=15, number=2, back=1.5,
        least_quality=0.0,
    ),
    "matching.pick": lambda: dict(image=GREY, number=3, template=11, margin=8),
    "matching.quality": lambda: BOTH | dict(found=matches()["B"], template=11),
    "ncc.match": lambda: BOTH | dict(
        start=CHOSEN, template=11, search=21, refine="parabola",
        lines=[(0, 1, -20.0), (0, 1, -22.0)], back=1.0,
    ),
    "ncc.correlation": lambda: dict(a=GREY[:11, :11], b=GREY[3:14, :11]),
    "ncc.regression": lambda: dict(a=GREY[:11, :11], b=GREY[3:14, :11]),
    "ncc.correlation_map": lambda: dict(template=GREY[:5, :5], search=GREY[:11, :11]),
    "observations.from_matches": lambda: dict(
        left_points=CHOSEN, matches=matches(), image_size=(48, 44), pixel_size=0.5,
        left="A", points=["p", "q"],
    ),
    "orientation.absolute": lambda: dict(
        source=POINTS, target=2 * POINTS + 7, sigma=0.5
    ),
    "orientation.Absolute.apply": lambda: dict(self=similarity(), points=POINTS),
    "orientation.Absolute.apply_covariance": lambda: dict(
        self=similarity(), points=POINTS
    ),
    "orientation.intersect": lambda: dict(
        cameras=[LENS, LENS], exteriors=[PHOTO, NEXT], sigma=0.5,
        image_points=np.array([projected(PHOTO), projected(NEXT)]),
        seen=np.ones((2, 5), bool),
    ),
    "orientation.relative": lambda: relative_pair() | dict(base=1.0, sigma=0.5),
    "orientation.resect": lambda: dict(
        camera=LENS, object_points=POINTS, image_points=projected(PHOTO), start=PHOTO,
        sigma=0.5,
    ),
    "orientation.scale_factors": lambda: PAIR | RAYS,
    "registration.accuracy": lambda: dict(dx=[0.5, -0.25, 0.1], dy=[0.0, 1.0, 0.2]),
    "registration.Accuracy.times": lambda: dict(
        self=registration.accuracy([0.5, -0.25], [0.0, 1.0]), pixel_size=(2.0, 3.0)
    ),
    "registration.approximate": lambda: dict(
        reference=GREY, sensed=GREY, chip=11, offset=(0.5, 1.0)
    ),
    "registration.common_grid": lambda: dict(reference=raster(), sensed=raster()),
    "registration.fit": lambda: dict(found=registered(), offset=(1.0, 2.0)),
    "registration.grid": lambda: dict(shape=(48, 44), step=5),
    "registration.Model.apply": lambda: dict(
        self=registration.fit(registered()), points=UP
    ),
    "registration.offset": lambda: dict(reference=raster(), sensed=raster()),
    "registration.pick": lambda: dict(
        image=GREY, number=3, chip=11, sensed=GREY, offset=(0.5, 1.0)
    ),
    "registration.Raster.map": lambda: dict(self=raster(), pixels=UP),
    "registration.Raster.pixels": lambda: dict(self=raster(), map_points=UP),
    "registration.Raster.with_values": lambda: dict(self=raster(), values=GREY),
    "registration.register": lambda: dict(
        reference=GREY, sensed=GREY, points=CHOSEN, chip=11, refine="lsm",
        largest_sd=0.5, offset=(0.0, 0.0), nodata=0.0, start=np.zeros((len(CHOSEN), 2)),
    ),
    "registration.resample": lambda: dict(
        sensed=GREY, model=registration.fit(registered()), shape=(40, 50)
    ),
    "rotation.matrix": lambda: ANGLES,
    "rotation.derivatives": lambda: ANGLES,
    "rotation.small_angle": lambda: ANGLES,
    "rotation.from_tilt_azimuth_swing": lambda: dict(
        tilt=0.5, azimuth=0.25, swing=0.125
    ),
    "rotation.to_tilt_azimuth_swing": lambda: dict(
        M=np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
    ),
    "rotation.from_quaternion": lambda: dict(quaternion=(1.0, 0, 0, 0)),
    "rotation.from_rodrigues": lambda: dict(vector=(0.5, 0.25, 0.125)),
    "rotation.angle_between": lambda: dict(first=ONE_MATRIX["M"], second=np.eye(3)),
    "rotation.best_fit": lambda: dict(product=np.diag([4.0, 3, 5])),
    **{
        f"rotation.{name}": lambda: ONE_MATRIX
        for name in (
            *("angles", "is_gimbal", "to_quaternion", "to_rodrigues", "defect"),
            "nearest",
        )
    },
    "stereo.NormalPair.parallax": lambda: dict(
        self=epipolar_pair(), disparity=[0.5, 1.5]
    ),
    "stereo.NormalPair.object_points": lambda: dict(
        self=epipolar_pair(), columns=[3.0, 4], rows=[5.0, 6], disparity=[0.5, 1.5]
    ),
    "stereo.NormalPair.from_photo": lambda: dict(
        self=epipolar_pair(), side=1, pixels=UP
    ),
    "stereo.NormalPair.to_photo": lambda: dict(
        self=epipolar_pair(), side=1, pixels=UP
    ),
    "stereo.epipolar_pair": lambda: oriented_pair() | dict(
        heights=(0.0, 5), depths=None
    ),
    "stereo.filter_terrain": lambda: dict(dsm=hilly_surface(), least=0.5, most=3.0),
    "stereo.intersect": lambda: dict(pair=normal_pair(), match=dense_match()),
    "stereo.match_dense": lambda: dict(pair=normal_pair()),
    "stereo.match_rows": lambda: dict(
        left=GREY, right=GREY, search=5, threshold=0.5
    ),
    "stereo.neighbours": lambda: dict(
        photos=list(oriented_pair().values()), ground=0.0, least=0.1, most=1.0
    ),
    "stereo.quality": lambda: dict(
        heights=[1.0, 2, 4], truth=[1.0, 2, 3], where=[True, False, True]
    ),
    "stereo.scale_factors": lambda: PAIR | RAYS,
    "stereo.surface": lambda: dict(
        points=POINTS, cell=2.0, extent=(0.0, -10, 30, 15), largest_gap=20.0
    ),
    "stereo.y_parallax": lambda: dict(pair=epipolar_pair(), points=CHOSEN),
}  # fmt: skip
