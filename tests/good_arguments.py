"""Good arguments of every public function, small, so that bad ones can be made of them.

A function or an argument that is missing here fails `test_bad_input`. What has a
default that is not None needs no entry.
"""

import copy
import dataclasses
import inspect
import itertools
from functools import cache
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from pgm_book.common import ledger
from pgm_lab import (
    bundle,
    camera,
    datasets,
    image,
    lsm,
    matching,
    ncc,
    observations,
    registration,
    simulate,
    stereo_map,
)
from pgm_lab import stereo as stereo_room
from pgm_lab.adjustment import adjust
from pgm_lab.orientation import absolute
from pgm_lab.plot import space

FOLDER = Path()
LENS = camera.Camera(35.0, 0.1, -0.1, K1=1e-5)
PLAIN = np.array([35.0] + 9 * [0.0])
PHOTO = (10.0, 5.0, 100.0, 0.02, -0.01, 0.3)
NEXT = (30.0, 6.0, 101.0, -0.02, 0.01, 0.2)
POINTS = np.array([(20.0, 2, 4), (12, 9, 8), (3, 14, -6), (25, -8, 1), (14, 4, -9)])
MATRIX = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
GREY = simulate.grey_values(
    simulate.texture(seed=1), np.stack(np.meshgrid(np.arange(48), np.arange(44)), -1)
)
WIDE = datasets.yellowstone().grey[:140, :140]
ORTHO = datasets.yellowstone().grey[:60, :60]
SPOT = simulate.target((10.25, 9.5), diameter=8)
ONE_CHIP = dict(reference=GREY, sensed=GREY, point=(20.0, 20), chip=9)
OBSERVED = dict(A=np.eye(4, 3) + 1, p=np.ones(4), observed=np.arange(4.0))
LOOP = dict(
    A=np.array([[1.0, 0], [-1, 1], [0, -1]]), p=np.array([1.0, 2, 0.5]), sigma0=0.001,
    lines=["AB", "BC", "CA"],
)  # fmt: skip
UP = np.array([(0.0, 0), (1, 0), (0, 1), (1, 1), (2, 1)])


@cache
def net():
    return simulate.network(LENS, 4, 12, np.random.default_rng(1))


def textbook_network():
    return dict(
        photo=net().photo,
        point=net().point,
        xy=net().xy,
        sigma=0.001,
        camera=PLAIN,
        exteriors=net().exteriors,
        points=net().points,
    )


@cache
def network():
    n = net()
    return bundle.Network(n.camera, n.exteriors, n.points, n.photo, n.point, n.xy)


@cache
def adjusted():
    return bundle.adjust(network(), ("c", "K1"))


@cache
def matches():
    chosen = np.array([(20.0, 20.0), (26, 22)])
    found = ncc.match(GREY, GREY, chosen, template=11, search=21)
    return chosen, {"B": lsm.match(GREY, GREY, chosen, found.points, template=11)}


@cache
def matched():
    chosen, _ = matches()
    return matching.match(GREY, GREY, chosen, start=chosen, template=11, search=15)


@cache
def registered():
    chosen = np.array([(20.0, 20.0), (26, 22)])
    return registration.register(GREY, GREY, chosen, chip=11, refine="lsm")


def raster():
    transform = np.array([[2.0, 0, 100], [0, -2, 500]])
    return registration.Raster(GREY, np.zeros(GREY.shape, bool), transform)


@cache
def observed():
    chosen, found = matches()
    return observations.from_matches(chosen, {2: found["B"]}, (48, 44), 0.5, left=1)


@cache
def session():
    pair = simulate.aerial_pair((120, 90), trees=0, buildings=0)
    return stereo_map.open_pair(pair.left, pair.right)


@cache
def clicked():
    pixels = itertools.product(range(20, 100, 8), range(20, 70, 8))
    points = (stereo_map.measure(session(), pixel) for pixel in pixels)
    return next(point for point in points if point.accepted)


@cache
def one_point():
    return stereo_map.add(session(), clicked())


@cache
def many_points():
    """Measured points moved to where photos of a wide angle show some."""
    known = simulate.network(LENS, 2, 12, np.random.default_rng(1))
    points = tuple(
        dataclasses.replace(
            clicked(), name=int(name) + 1, photo=known.xy[known.point == name]
        )
        for name in range(12)
        if np.sum(known.point == name) == 2
    )
    return dataclasses.replace(session(), points=points)


def new_file():
    """A file in the temporary folder of the test, which `test_bad_input` names."""
    return FOLDER / "new.csv"


@cache
def axes():
    return plt.figure(figsize=(2, 2)).add_subplot()


@cache
def axes_in_space():
    return space.space(plt.figure(figsize=(2, 2)))


def bordered():
    """A normal matrix of five points, bordered by their inner constraints."""
    return bundle.dense.bordered(np.eye(15), bundle.dense.G(POINTS))


def line(x, at):
    """Observation equations of a straight line, for `adjust`."""
    A = np.stack([np.ones_like(at), at], axis=-1)
    return A @ x, A


def to_one(x, at):
    """A condition between the unknowns of a line: they add up to 1.5."""
    return np.array([x.sum() - 1.5]), np.ones((1, 2))


@cache
def ray_blocks():
    n = network()
    return bundle.dense.derivatives(
        n.interior[0], n.exteriors, n.points, n.photo, n.point, n.xy
    )


@cache
def dense_matrix():
    n = network()
    v, A1, A3, A2 = ray_blocks()
    m, k = len(n.exteriors), len(n.points)
    return bundle.dense.design(A1, A3, A2, n.photo, n.point, m, k)


def normal_pair():
    origin = np.array([(2.0, 0.0), (-4.0, 0.0)])
    stations = np.array([(0.0, 0, 1000), (400.0, 0, 1000)])
    grey = ORTHO.astype(float)
    return stereo_room.NormalPair(grey, grey, np.eye(3), stations, 24.0, 0.005, origin)


def dense_match():
    shape, rng = normal_pair().left.shape, np.random.default_rng(3)
    d = rng.normal(0, 5, shape).astype(np.float32)
    known = np.ones(shape, np.float32)
    status = np.zeros(shape, np.uint8)
    return stereo_room.DenseMatch(d, 0.9 * known, 0.3 * known, status)


def object_points():
    return stereo_room.intersect(normal_pair(), dense_match(), step=9)


def hilly_surface():
    z = np.tile(np.linspace(0.0, 3, 30), (30, 1))
    z[10:16, 12:18] += 6.0
    return stereo_room.Surface(z, (0.0, 15.0), 0.5, np.ones(z.shape, bool))


def level_land():
    flat = np.full((40, 40), 20.0, np.float32)
    return simulate.Landscape(flat, flat, flat, flat, (-200.0, 200.0), 10.0)


def level_surface():
    z = np.full((4, 5), 20.0)
    return stereo_room.Surface(z, (-150.0, 150.0), 10.0, z > 0)


def level_terrain():
    z = np.full((4, 5), 20.0)
    return stereo_room.Terrain(z, np.zeros((4, 5), np.uint8), (-150.0, 150.0), 10.0)


@cache
def measured_surface():
    X, Y = np.meshgrid(np.arange(0.0, 30, 2), np.arange(0.0, 24, 2))
    hill = 20 + np.hypot(X - 14, Y - 12) / 10
    return stereo_room.surface(np.stack([X, Y, hill], -1).reshape(-1, 3), 2.0)


def oriented():
    return camera.Photo(GREY, LENS, PHOTO, 0.005)


@cache
def oriented_pair():
    photos = (camera.Photo(GREY, LENS, one, 0.5) for one in (PHOTO, NEXT))
    return dict(zip(("left", "right"), photos))


@cache
def epipolar_pair():
    return stereo_room.epipolar_pair(**oriented_pair(), heights=(0, 5))


def rng():
    return np.random.default_rng(1)


def rays():
    n = network()
    return dict(
        interior=n.interior[0],
        exteriors=n.exteriors,
        points=n.points,
        photo=n.photo,
        point=n.point,
        xy=n.xy,
    )


def exterior_and_image():
    points = POINTS
    return points, camera.project(LENS, PHOTO, points)


def stereo():
    return np.array([camera.project(LENS, p, POINTS) for p in (PHOTO, NEXT)])


def relative_pair():
    truth, left, right = simulate.pair(camera.Camera(35.0), 8, rng())
    return truth[1:], left, right


def line_fit(**more):
    at = np.array([0.0, 1, 2, 3])
    return (
        dict(
            function=line,
            start=np.zeros(2),
            observations=np.array([0.5, 1.5, 2.6, 3.4]),
            args=(at,),
        )
        | more
    )


EYE = {"M": MATRIX}
ANGLES = {"omega": 0.5, "phi": 0.25, "kappa": -0.5}
PIXELS = {"image_size": (40, 30), "pixel_size": 0.5}
INTEREST = {"left": GREY, "right": GREY, "points": [(20, 20), (26, 22)]}
SCENE = {
    "lens": camera.Camera(5.0),
    "exterior": (5.0, 5, 100, 0.02, -0.01, 0.3),
    "relief": simulate.texture(0.01, contrast=3.0, mean=10.0, waves=20),
}
PHOTOS = {"lens": LENS, "n": 5, "rng": rng()}
SIZES = {"photo": [0, 0, 1], "point": [0, 1, 1]}
NET = np.array([[4.0, 1, 0], [1, 3, 1], [0, 1, 5]])
STATION = {"exterior": (0.0, 0, 50, 0.5, 0.25, -0.5)}
FACES = [(np.array([(0.0, 0, 0), (1, 0, 0), (1, 1, 0)]), "red")]


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


FUNCTIONS = {
    "adjustment.adjust": lambda: line_fit(
        weights=np.ones(4), parameter_weights=np.ones(2), parameter_values=np.zeros(2),
        covariance=None, sigma0_prior=1.0, constraints=to_one, names=["a", "b"],
    ),
    "adjustment.Adjustment.global_test": lambda: dict(
        self=adjust(**line_fit(sigma0_prior=1.0))
    ),
    "adjustment.critical_tau": lambda: dict(alpha=0.001, redundancy=20),
    "adjustment.critical_w": lambda: dict(alpha=0.001),
    "bundle.adjust": lambda: dict(network=network(), estimate=("c",), datum="inner",
                                  sigma0_prior=1.0, max_iterations=20),
    "bundle.correlations": lambda: dict(result=adjusted()),
    "bundle.critical_value": lambda: dict(result=adjusted()),
    "bundle.motions": lambda: dict(positions=POINTS),
    "bundle.reliability": lambda: dict(result=adjusted()),
    "bundle.significance": lambda: dict(result=adjusted()),
    "bundle.snoop": lambda: dict(network=network(), estimate=("c",), datum="inner",
                                 sigma0_prior=1.0),
    "bundle.Network": in_network,
    "bundle.Network.of": tables,
    "bundle.Network.without": lambda: dict(self=network(), rays=[0, 1]),
    "bundle.Network.only": lambda: dict(self=network(), photos=[0, 1, 2]),
    "bundle.dense.derivatives": rays,
    "bundle.dense.design": lambda: dict(
        zip(("A1", "A3", "A2"), ray_blocks()[1:]),
        photo=network().photo, point=network().point, m=4, n=12,
        camera=np.zeros(4, int),
    ),
    "bundle.dense.normal_matrix": lambda: dict(A=np.eye(4, 3), sigma=np.full(4, 0.5)),
    "bundle.dense.G": lambda: dict(points=POINTS),
    "bundle.dense.bordered": lambda: dict(
        N=np.eye(21), G=bundle.dense.G(POINTS)
    ),
    "bundle.dense.scaled": lambda: dict(N=bordered()),
    "bundle.dense.inverse": lambda: dict(N=bordered()),
    "bundle.dense.solve": lambda: dict(N=bordered(), t=np.ones(15)),
    "plot.search.numbers": lambda: dict(windows={"a": GREY[:5, :5]}),
    "plot.search.arrows": dict,
    "plot.search.parts": lambda: dict(
        left=WIDE, right=WIDE, point=(70, 70), start=(70, 70)
    ),
    "plot.search.templates": lambda: dict(
        left=WIDE, right=WIDE, point=(70, 70), start=(70, 70), sizes=(5, 9)
    ),
    "datasets.StereoPair.known": lambda: dict(
        self=datasets.motorcycle(), columns=[300, 320], rows=[318]
    ),
    "plot.search.by_hand": lambda: dict(
        left=datasets.motorcycle().left, right=datasets.motorcycle().right,
        disparity=datasets.motorcycle().disparity,
    ),
    "plot.troubles.six": lambda: dict(
        pair=datasets.motorcycle(), ground=datasets.yellowstone().grey
    ),
    "plot.troubles.right_and_wrong": lambda: dict(
        photo=GREY, points=UP, right=np.array([True, False, True, True, True])
    ),
    "plot.subpixel.summit": lambda: dict(r=[0.5, 0.9, 0.7]),
    "plot.subpixel.locking": lambda: dict(
        shifts=[0.0, 0.5], errors={"soft": [0.0, 0.01]}
    ),
    "plot.subpixel.depths": lambda: dict(
        photo=GREY, points=UP, measured=np.arange(5.0), true=np.arange(5.0)
    ),
    "plot.twentyfive.two_maps": lambda: dict(
        scene=GREY, quick=np.eye(5), exact=np.eye(5)
    ),
    "plot.twentyfive.before_and_after": lambda: dict(
        r={"before": [0.5, 0.9], "after": [0.6, 0.8]}
    ),
    "plot.twentyfive.study": lambda: dict(
        widths=[5.0, 15], shares={"texture": [0.5, 0.9]}, rms={"texture": [0.3, 0.1]}
    ),
    "plot.twentyfive.reach": lambda: dict(
        start=(20, 20), match=(24, 19), windows={"small": 25}, size=9
    ),
    "bundle.textbook.without_lens": lambda: dict(xy=UP, camera=PLAIN),
    "bundle.textbook.misclosure": lambda: dict(
        unknowns=[*PLAIN, *PHOTO, 0, 0, 0], points=POINTS, xy=UP
    ),
    "bundle.textbook.blocks": lambda: textbook_network(),
    "bundle.textbook.adjust": lambda: textbook_network(),
    "bundle.textbook.reduced": lambda: dict(
        K=np.eye(4), E=np.zeros((2, 4, 3)), V=np.stack([np.eye(3)] * 2)
    ),
    "plot.calibrate.ray": dict,
    "plot.calibrate.lens_grids": dict,
    "plot.calibrate.lens_by_hand": dict,
    "plot.calibrate.zeros": lambda: dict(photo=net().photo, point=net().point),
    "plot.calibrate.motions": lambda: dict(
        exteriors=net().exteriors, points=net().points
    ),
    "plot.calibrate.curve": lambda: dict(result=adjusted()),
    "plot.calibrate.wrong_control": lambda: dict(
        wrong=[0.0, 1.0], sd=[0.02, 0.02], error=[0.02, 0.4]
    ),
    "plot.calibrate.which_photos": lambda: dict(given=network()),
    "plot.program.by_photo": lambda: dict(rms={"start": [0.1, 0.2]}),
    "plot.program.steps": lambda: dict(runs={"none": [0.1, 0.01]}),
    "plot.program.kept": lambda: dict(values={"N": [5.0, 2, 0.5]}, limit=1.0),
    "plot.program.left_over": lambda: dict(result=adjusted()),
    "plot.program.networks": lambda: dict(given={"A": (net().exteriors, POINTS)}),
    "plot.program.precisions": lambda: dict(sds={"A": [14.0, 7, 7]}),
    "plot.program.scatter": lambda: dict(ratio={"c": 1.02, "x0": 0.99}, networks=2000),
    "plot.program.speed": lambda: dict(
        rays=[450, 1800],
        seconds={"ours": [0.1, 0.2]},
        megabytes=[1.0, 6],
        labels=["9", "20"],
    ),
    "bundle.lens.radial": lambda: dict(camera=LENS, image=UP),
    "bundle.lens.decentring": lambda: dict(camera=LENS, image=UP),
    "bundle.lens.affinity": lambda: dict(camera=LENS, image=UP),
    "bundle.lens.profile": lambda: dict(result=adjusted(), rho=[0.0, 5, 10]),
    "bundle.lens.places": lambda: dict(result=adjusted(), camera=0),
    "bundle.published.network": lambda: dict(photos=[1, 4, 7]),
    "camera.Camera": lambda: dict(c=35.0),
    "camera.Photo": lambda: dict(
        grey=GREY, camera=LENS, exterior=PHOTO, pixel_size=0.5, image_size=(60, 50),
        corner=(2, 3),
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
    "adjustment.textbook.adjust": lambda: dict(OBSERVED),
    "adjustment.textbook.normal_equations": lambda: dict(OBSERVED),
    "lsm.textbook.row_shift": lambda: dict(A=[1.0, 2, 4, 7], B=[1.5, 2, 3, 6]),
    "lsm.textbook.match": lambda: dict(
        left=GREY, right=GREY, point=(20, 20), start=[20, 1, 0, 20, 0, 1, 0, 1], size=11
    ),
    "lsm.textbook.resampled": lambda: dict(
        right=GREY, p=[20, 1, 0, 20, 0, 1, 0, 1], x=[0.0, 1], y=[1.0, 2]
    ),
    "lsm.textbook.design": lambda: dict(
        B=[90.0, 80], Bx=[2.0, 1], By=[1.0, 3], x=[-3.0, 1], y=[4.0, 2], h1=1.5
    ),
    "plot.windows.pair": lambda: dict(
        left=GREY, right=GREY, point=(20, 20), affine=[(1, 0, 1), (0, 1, 2)], window=9
    ),
    "plot.windows.slope": lambda: dict(A=[1.0, 2, 4, 7], B=[1.5, 2, 3, 6], place=2),
    "plot.windows.eight": lambda: dict(photo=GREY, point=(20, 20), window=9),
    "plot.lsm.film": lambda: dict(
        left=GREY, right=GREY, point=(20, 20), size=9,
        trail=[[20, 1, 0, 20, 0, 1, 0, 1]], truth=(20, 20),
    ),
    "plot.lsm.by_hand": lambda: dict(
        left=GREY, right=GREY, point=(20, 20), size=9, truth=(20, 20)
    ),
    "plot.lsm.interpolation": dict,
    "plot.lsm.half_wave": dict,
    "plot.lsm.pull_in": dict,
    "plot.lsm.ellipses": lambda: dict(
        left=GREY, places={"a": (20, 20)},
        clouds={"a": (np.zeros((3, 2)), np.eye(2) * 1e-4)},
    ),
    "plot.trials.origin": lambda: dict(
        distance=[0.0, 10], condition=[4.0, 90], determinant=[1.0, 1], sd=[1.0, 3]
    ),
    "plot.trials.s0": lambda: dict(sizes=[7.0, 11], right=[6.0, 6.1]),
    "plot.trials.costs": dict,
    "plot.trials.radiometric": lambda: dict(
        gains=[0.9, 1.1], eight=[0.003, 0.003], six=[0.02, 0.03]
    ),
    "plot.trials.on_photo": lambda: dict(photo=GREY, points=UP, errors=np.ones(5)),
    "adjustment.textbook.redundancy_numbers": lambda: dict(
        A=OBSERVED["A"], p=OBSERVED["p"]
    ),
    "adjustment.textbook.suspect": lambda: dict(
        v=np.array([4.0, -9, -3]), sigma=np.array([2.0, 5, 1.2]),
        r=np.array([0.6, 0.7, 0.12]),
    ),
    "adjustment.textbook.ellipse": lambda: dict(covariance=[[2.0, 0.5], [0.5, 1.0]]),
    "camera.textbook.derivatives": lambda: dict(function=np.sin, at=np.arange(3.0)),
    "camera.textbook.project": lambda: dict(exterior=PHOTO, points=POINTS, c=35.0),
    "camera.collinearity": lambda: dict(
        camera=LENS, exterior=PHOTO, points=POINTS, measured=UP
    ),
    "camera.ideal": lambda: dict(camera=LENS, measured=UP),
    "camera.measured": lambda: dict(camera=LENS, ideal=UP),
    "camera.project": lambda: dict(camera=LENS, exterior=PHOTO, points=POINTS),
    "chapters.markdown": dict,
    "checks.near": lambda: dict(answer=UP, expected=UP),
    "checks.chapter6c.rescaled": lambda: dict(N=NET),
    "checks.own": lambda: dict(name="largest", book=max),
    "checks.predict": lambda: dict(number="2.1"),
    "datasets.rows": lambda: dict(name="chapters.csv"),
    "epipolar.curve": lambda: oriented_pair() | dict(
        pixel=(20.0, 20), heights=[0.0, 5], depths=None
    ),
    "epipolar.distance": lambda: oriented_pair() | dict(
        left_pixels=UP, right_pixels=UP
    ),
    "epipolar.epipole": oriented_pair,
    "epipolar.essential": lambda: dict(left_exterior=PHOTO, right_exterior=NEXT),
    "epipolar.fundamental": lambda: oriented_pair() | dict(corrected=True),
    "epipolar.line": lambda: oriented_pair() | dict(pixels=UP),
    "epipolar.plane": lambda: oriented_pair() | dict(pixels=UP),
    "frames.image_centre": lambda: dict(image_size=(40, 30)),
    "frames.pixel_to_photo": lambda: dict(
        pixels=UP, **PIXELS, covariance=np.tile(np.eye(2), (5, 1, 1))
    ),
    "frames.photo_to_pixel": lambda: dict(
        photo=UP, **PIXELS, covariance=np.tile(np.eye(2), (5, 1, 1))
    ),
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
    "image.centroid": lambda: dict(window=SPOT, background=40.0, sigma=1.0),
    "image.statistics": lambda: dict(image=GREY),
    "image.histogram": lambda: dict(image=GREY.round().astype(np.uint8)),
    "image.equalize": lambda: dict(image=GREY.round().astype(np.uint8)),
    "image.gradient": lambda: dict(image=GREY),
    "image.pyramid": lambda: dict(image=GREY, levels=2),
    "image.resample": lambda: dict(image=GREY, points=[(3.5, 4), (5, 6)], outside=1.0),
    "image.cut": lambda: dict(image=GREY, centre=(20.0, 20), size=5),
    "ledger.verdicts": lambda: dict(
        chapter="1", places=["Metode, GSD"], source="Harintaka 2020",
        verdict="corrected",
    ),
    "ledger.code": lambda: dict(equation="M 2.38"),
    "ledger.equations": lambda: dict(row=ledger.verdicts("5")[0]),
    "ledger.table": lambda: dict(rows=ledger.verdicts("1"), caption="Verdicts"),
    "ledger.figure": lambda: dict(rows=ledger.verdicts("1")),
    "ledger.summary": lambda: dict(rows=ledger.verdicts("1")),
    "lsm.match": lambda: INTEREST | dict(
        start=[(20.0, 20), (26, 22)], template=11, shape=np.eye(2)
    ),
    "lsm.adjust": lambda: dict(
        left=GREY, right=GREY, points=[(20.0, 20)],
        parameters=[(20.25, 1, 0, 20, 0, 1, 0, 1)], template=11,
    ),
    "lsm.cramer_rao": lambda: dict(
        grey=GREY[:11, :11],
        gradients=np.stack(image.gradient(GREY), -1)[:11, :11], sigma=1.0,
        shape=np.eye(2),
    ),
    "lsm.defects.match": lambda: INTEREST | dict(
        start=[(20.0, 20), (26, 22)], template=11
    ),
    "matching.match": lambda: INTEREST | dict(
        start=[(20.0, 20), (26, 22)], shape=np.eye(2), template=11, search=15,
        number=2, back=1.5, least_quality=0.0,
    ),
    "matching.Match.save": lambda: dict(self=matched(), path=new_file()),
    "matching.pick": lambda: dict(image=GREY, number=3, template=11, margin=8),
    "matching.quality": lambda: dict(
        left=GREY, right=GREY, points=matches()[0], found=matches()[1]["B"], template=11
    ),
    "matching.read": lambda: dict(photo=GREY, name="left"),
    "stereo_map.open_pair": lambda: dict(
        left=GREY, right=GREY, camera=LENS, pixel_size=0.005,
        exteriors=[PHOTO, NEXT], heights=(0.0, 9.0),
    ),
    "stereo_map.measure": lambda: dict(
        session=session(), pixel=(20.0, 20), near=(22.0, 20), reach=9.0
    ),
    "stereo_map.add": lambda: dict(session=session(), point=clicked()),
    "stereo_map.undo": lambda: dict(session=one_point()),
    "stereo_map.orient": lambda: dict(
        session=many_points(), control={1: (0.0, 0, 0), 2: (1, 0, 0), 3: (0, 1, 0.0)}
    ),
    "stereo_map.observations": lambda: dict(session=one_point()),
    "stereo_map.network": lambda: dict(session=one_point()),
    "stereo_map.draw": lambda: dict(session=session(), point=clicked()),
    "stereo_map.show": lambda: dict(session=session(), point=clicked()),
    "observations.Observations.save": lambda: dict(
        self=observed(), path=new_file(), overwrite=True
    ),
    "ncc.match": lambda: dict(
        left=GREY, right=GREY, points=[(20, 20), (26, 22)], start=[(20, 20), (26, 22)],
        template=11, search=21, refine="parabola",
        lines=[(0, 1, -20.0), (0, 1, -22.0)], back=1.0,
    ),
    "ncc.correlation": lambda: dict(a=GREY[:11, :11], b=GREY[3:14, :11]),
    "ncc.regression": lambda: dict(a=GREY[:11, :11], b=GREY[3:14, :11]),
    "ncc.correlation_map": lambda: dict(template=GREY[:5, :5], search=GREY[:11, :11]),
    "observations.from_matches": lambda: dict(
        zip(("left_points", "matches"), matches()),
        **{"image_size": (48, 44), "pixel_size": 0.5, "left": "A"}, points=["p", "q"],
    ),
    "orientation.absolute": lambda: dict(
        source=POINTS, target=2 * POINTS + 7, sigma=0.5
    ),
    "orientation.Absolute.apply": lambda: dict(
        self=absolute(POINTS, 2 * POINTS + 7 + UP[:, :1] / 8), points=POINTS
    ),
    "orientation.Absolute.apply_covariance": lambda: dict(
        self=absolute(POINTS, 2 * POINTS + 7 + UP[:, :1] / 8), points=POINTS
    ),
    "orientation.intersect": lambda: dict(
        cameras=[LENS, LENS], exteriors=[PHOTO, NEXT], image_points=stereo(),
        seen=np.ones((2, 5), bool), sigma=0.5,
    ),
    "orientation.relative": lambda: dict(
        zip(("start", "left_points", "right_points"), relative_pair()),
        camera_left=camera.Camera(35.0), camera_right=camera.Camera(35.0),
        base=1.0, sigma=0.5,
    ),
    "orientation.resect": lambda: dict(
        zip(("object_points", "image_points"), exterior_and_image()),
        camera=LENS, start=PHOTO, sigma=0.5,
    ),
    "orientation.scale_factors": lambda: dict(
        left_exterior=PHOTO, right_exterior=NEXT,
        left_rays=[(1.0, 2, -35)], right_rays=[(-6.0, 2, -35)],
    ),
    "stereo.scale_factors": lambda: FUNCTIONS["orientation.scale_factors"](),
    "orientation.as_printed.coefficients": lambda: dict(f=50.0, point=POINTS[0])
    | STATION,
    "orientation.as_printed.moved_by_each": lambda: dict(f=50.0, point=POINTS[0])
    | STATION,
    "plot.show": lambda: dict(fig=plt.figure(figsize=(1, 1)), alt="Nothing", colours=8),
    "plot.table": lambda: dict(header=["a", "b"], rows=[["1", "2"]], caption="Two"),
    "plot.error_ellipse": lambda: dict(
        ax=axes(), position=(1.0, 2), covariance=[[4.0, 1], [1, 2]]
    ),
    "plot.frame": lambda: dict(
        ax=axes(), origin=(0.0, 0), x_end=(1.0, 0), y_end=(0.0, 1)
    ),
    "plot.pixel_on_ground": lambda: dict(ortho=datasets.yellowstone()),
    "plot.bundle.lens_curve": lambda: dict(result=adjusted(), rho_max=10.0),
    "plot.bundle.residual_vectors": lambda: dict(
        result=adjusted(), photo=1, magnify=100.0, critical=3.0
    ),
    "plot.bundle.standardized_histogram": lambda: dict(
        result=adjusted(), critical=3.0
    ),
    "plot.fifty.on_the_grid": lambda: dict(sets={"A": [(2.0, 1), (2, 2)]}),
    "plot.fifty.sums": lambda: dict(
        blind=[(2.0, 1), (-3, 3)], drawn={"A": [380.0, 400, 420]}, printed=286.0
    ),
    "plot.fifty.beyond": lambda: dict(
        true=[0.0, 3, 4], reported=[0.0, 3, 3], reached=[1.0, 1, 0.8]
    ),
    "plot.fifty.r_and_shift": lambda: dict(
        r=[0.9, 0.5], shift=[2.2, 4.2], error=[0.1, 3.0]
    ),
    "plot.fifty.chips": lambda: dict(
        reference=ORTHO, sensed=ORTHO, points=[(30.0, 28)], shifts=[(1.0, -1)]
    ),
    "plot.matching.draw_window": lambda: dict(
        ax=axes(), image=GREY, centre=(20.0, 20), size=5
    ),
    "plot.matching.outline": lambda: dict(ax=axes(), centre=(20.0, 20), size=5.0),
    "plot.matching.shifts": lambda: dict(r=np.eye(3)),
    "plot.matching.draw_map": lambda: dict(ax=axes(), r=np.eye(3)),
    "plot.matching.draw_surface": lambda: dict(ax=axes_in_space(), r=np.eye(3) / 2),
    "plot.matching.film_strip": lambda: dict(
        left=GREY, right=GREY, point=(20, 20), window=5,
        parameters=[(20.0, 1, 0, 20, 0, 1, 0, 1)], notes=["start"],
    ),
    "plot.overlay": lambda: dict(reference=GREY, sensed=GREY, ax=axes()),
    "plot.locations.six": lambda: dict(
        points=[44.0, 71], interactive=[1.39, 1.71], automatic=[1.42, 1.75]
    ),
    "plot.locations.marks": lambda: dict(
        pair=normal_pair(), places=[(30.0, 30)], starts=[1.0]
    ),
    "plot.locations.gaps": lambda: dict(
        land=level_land(), spots=[(-150.0, 150, 20), (-120, 120, 20)],
        dsm=level_surface(), dtm=level_terrain(), row=1,
    ),
    "plot.locations.compared": lambda: dict(
        alone={"open": [0.2, 0.1]}, common={"open": [1.4, 1.5]}, longer=0.5
    ),
    "plot.locations.bowl": lambda: dict(
        points=[(0.0, 0), (1, 1)], errors=[1.0, -1.0], parallaxes=[0.1, 0.0]
    ),
    "plot.mark.positions": lambda: dict(
        pair=normal_pair(), place=(30.0, 30), disparities=[-1.0, 0, 1]
    ),
    "plot.mark.by_hand": lambda: dict(pair=normal_pair(), place=(30.0, 30)),
    "plot.stereo.photos": lambda: dict(left=oriented(), right=oriented()),
    "plot.stereo.laid": lambda: dict(pair=normal_pair(), disparity=2.0),
    "plot.stereo.epipolar_line": lambda: dict(
        left=oriented(), right=oriented(), pixel=(20.0, 20),
        line=[(0.0, 10), (30, 11)], places=[(10.0, 10), (12, 10)], heights=[0.0, 20],
    ),
    "plot.stereo.rows": lambda: dict(
        left=oriented(), right=oriented(), pair=normal_pair(), row=10
    ),
    "plot.stereo.y_parallaxes": lambda: dict(cases={"a": [0.1, -0.1, 0.2]}),
    "plot.stereo.search": lambda: dict(
        pair=normal_pair(), place=(30.0, 30), window=7, low=-5, high=5
    ),
    "plot.stereo.levels": lambda: dict(
        pyramid=[normal_pair()], matches=[dense_match()]
    ),
    "plot.sensor.frames": lambda: {},
    "plot.sensor.interior": lambda: {},
    "plot.sensor.conventions": lambda: {},
    "plot.sensor.shrunk": lambda: dict(offsets=[0.0, 1, 2], rms=[3.0, 1, 2]),
    "plot.sensor.ground": lambda: dict(grey=ORTHO, gsd=0.1, sizes=[0.2, 0.8]),
    "plot.target.pull": lambda: dict(
        window=SPOT, truth=(10.25, 9.5), centroids={"a": (10.0, 9)}
    ),
    "plot.target.by_hand": lambda: {},
    "plot.target.precision": lambda: {},
    "plot.target.sampled": lambda: dict(diameter=8.0, size=15),
    "plot.forty.mirror": lambda: dict(computed=UP, printed=UP * (1, -1)),
    "plot.forty.misfits": lambda: dict(
        point=np.arange(5), misfit=1e-6 * np.ones((2, 5, 2))
    ),
    "plot.forty.left_over": lambda: dict(listing=[1.2, 3.4], sensor=[5.0, 6]),
    "plot.levelling.net": lambda: dict(lines=["AB", "BC"], labels=["1 m", "2 m"]),
    "plot.levelling.control": lambda: dict(lines=["AB", "BC"], share=[0.3, 0.7]),
    "plot.levelling.tested": lambda: dict(
        LOOP, surveys={"a": np.array([3.001, -1.0, -1.999])}
    ),
    "plot.levelling.blunder": lambda: dict(
        LOOP, observed=np.array([3.001, -1.0, -1.999]), line="AB", size=10.0
    ),
    "plot.levelling.blunder_by_hand": lambda: dict(
        LOOP, observed=np.array([3.001, -1.0, -1.999])
    ),
    "plot.estimates.parabolas": lambda: dict(
        observed=np.array([10.0, 10.004]), p=np.array([3.0, 1.0]), names=["a", "b"]
    ),
    "plot.estimates.scatter": lambda: dict(
        sigma0s=np.array([1.0, 2.5]), ours=1.8, stated=2.0, redundancy=4
    ),
    "plot.estimates.tangent": lambda: dict(base=140.0, depth=240.0, start=720.0),
    "plot.estimates.point": lambda: dict(
        stations=[(0.0, 0), (60, 0)], position=(30.0, 200),
        covariance=[[4e-4, 1e-4], [1e-4, 4e-3]], errors=[(0.01, 0.02), (0.0, -0.03)],
    ),
    "plot.heights.profile": lambda: dict(
        own=[(0.0, 0, 20), (5, 0, 21)], book=[(0.0, 0, 20), (5, 0, 21)],
        land=level_land(),
    ),
    "plot.heights.terrain": lambda: dict(
        dsm=measured_surface(), dtm=stereo_room.filter_terrain(measured_surface()),
        land=level_land(),
    ),
    "plot.heights.threshold": lambda: dict(error=[0.1, 2.0, 0.2], r=[0.9, 0.5, 0.7]),
    "plot.heights.errors": lambda: dict(error=[0.1, -0.1, 0.0], sigma=0.1),
    "plot.start.computed_and_printed": lambda: dict(
        computed=(1.0, 2.0), printed=(1.0, -2.0), sensor_size=(24.0, 16.0)
    ),
    "plot.fringe.changes": lambda: dict(reference=GREY, sensed=GREY),
    "plot.fringe.two_colours": lambda: dict(
        reference=GREY, sensed=GREY, centre=(20.0, 20), size=21
    ),
    "plot.fringe.by_hand": lambda: dict(
        reference=GREY, sensed=GREY, centre=(20.0, 20), size=9
    ),
    "plot.fringe.before_and_after": lambda: dict(
        reference=GREY, sensed=GREY, again=GREY
    ),
    "plot.turns.three": lambda: dict(degrees=25.0),
    "plot.turns.quadrant": lambda: dict(degrees=131.0),
    "plot.cameras.views": lambda: dict(attitudes=[(0.0, 0, 0)], names=["one"]),
    "plot.cameras.two_orders": lambda: dict(omega=20.0, phi=30.0, kappa=40.0),
    "plot.cameras.around": lambda: dict(
        points=np.eye(3), cameras={"one": np.full((9, 6), 0.1)}
    ),
    "plot.printed.matrices": lambda: dict(omega=0.3, phi=0.4, kappa=0.5),
    "plot.printed.bench": lambda: dict(matrices={"one": np.eye(3)}),
    "plot.printed.rows_and_columns": lambda: dict(matrices={"one": np.eye(3)}),
    "plot.chips.search": lambda: dict(ONE_CHIP),
    "plot.chips.table_of_r": lambda: dict(ax=axes(), r=np.eye(3)),
    "plot.chips.chip_and_map": lambda: dict(
        reference=GREY, point=(20.0, 20), r=np.eye(3)
    ),
    "plot.chips.places": lambda: dict(image=GREY, points=[(20.0, 20), (25, 18)]),
    "plot.chips.parabola": lambda: dict(r_left=0.5, r_middle=0.9, r_right=0.7),
    "plot.shifts.darts": lambda: dict(
        methods={"a": np.ones((3, 2))}, truth=(1.25, -0.75)
    ),
    "plot.shifts.beyond": lambda: dict(
        true=[0.0, 2, 5], found=[0.0, 2, 3], r=[0.9, 0.9, 0.8]
    ),
    "plot.shifts.trial": lambda: dict(
        error=[0.1, 0.2, 5], r=[0.9, 0.7, 0.6], tests={"r": np.array([0.9, 0.7, 0.6])},
        accepted=np.array([True, True, False]),
    ),
    "registration.best_shift": lambda: dict(ONE_CHIP),
    "registration.peak_of_parabola": lambda: dict(
        r_left=0.5, r_middle=0.9, r_right=0.7
    ),
    "registration.rmse": lambda: dict(dx=[0.1, -0.3, 0.2], dy=[0.3, 0.1, -0.1]),
    "registration.chip_shifts": lambda: dict(
        reference=GREY, sensed=GREY, points=[(20.0, 20), (25, 18)], chip=9
    ),
    "plot.matches.side_by_side": lambda: dict(left=GREY, right=GREY, found=matched()),
    "plot.matches.parallaxes": lambda: dict(left=GREY, found=matched()),
    "plot.matches.histograms": lambda: dict(found=matched(), threshold=0.7),
    "plot.matches.remainders": lambda: dict(found=matched()),
    "plot.matrices.normal_blocks": lambda: dict(SIZES),
    "plot.matrices.normal_matrix": lambda: dict(SIZES),
    "plot.matrices.correlation_matrix": lambda: dict(result=adjusted()),
    "plot.matrices.spectrum": lambda: dict(
        values={"N": [5.0, 2, 0.5]}, tolerances={"N": 1.0}
    ),
    "plot.network.seven_motions": lambda: dict(
        exteriors=[PHOTO, NEXT], points=POINTS, view=(20.0, 30.0), size=5.0
    ),
    "plot.network.network_3d": lambda: dict(
        exteriors=[PHOTO, NEXT], points=POINTS,
        covariance_points=np.tile(np.eye(3), (5, 1, 1)), factor=2.0,
        view=(20.0, 30.0), size=5.0,
    ),
    "plot.network.ellipsoids": lambda: dict(
        positions=POINTS[:2], covariances=np.tile(np.eye(3), (2, 1, 1))
    ),
    "plot.registration.fringes": lambda: dict(reference=GREY, images={"other": GREY}),
    "plot.registration.shifts": lambda: dict(
        reference=GREY, found=registered(), vectors=np.ones((2, 2)), say=str
    ),
    "plot.registration.scatter": lambda: dict(
        found=registered(), errors=np.ones((2, 2))
    ),
    "plot.registration.similarity": lambda: dict(
        found=registered(), errors=np.ones((2, 2))
    ),
    "plot.space.space": lambda: dict(fig=plt.figure(figsize=(1, 1))),
    "plot.space.fit": lambda: dict(ax=axes_in_space(), points=POINTS),
    "plot.space.frustum": lambda: dict(STATION),
    "plot.space.draw_camera": lambda: dict(ax=axes_in_space(), **STATION),
    "plot.space.draw_axes": lambda: dict(
        ax=axes_in_space(), origin=(0.0, 1, 2), M=MATRIX
    ),
    "plot.space.draw_faces": lambda: dict(ax=axes_in_space(), faces=FACES),
    "plot.space.draw_photo": lambda: dict(
        ax=axes(), faces=FACES, ground="green", **STATION
    ),
    "plot.village.surroundings": dict,
    "plot.rays.one_ray": dict,
    "plot.rays.epipolar_plane": dict,
    "plot.rays.to_the_ground": dict,
    "plot.rays.meeting": lambda: dict(
        exteriors=[PHOTO, NEXT], points=POINTS, names=["left", "right"]
    ),
    "plot.precision.steps": lambda: dict(size=[1e-3, 1e-6], error=[1e-4, 1e-9]),
    "plot.precision.clouds": dict,
    "plot.precision.towards": lambda: dict(angle=40.0),
    "plot.precision.base_by_hand": dict,
    "plot.precision.vertical": lambda: dict(base=40.0),
    "plot.validation.heights": lambda: dict(z=np.ones((5, 10))),
    "plot.validation.residuals": lambda: dict(
        photos=np.ones((2, 3, 2)), v=np.full((2, 3, 2), 0.01)
    ),
    "plot.validation.ladder": lambda: dict(sigma0={"as printed": 1.5, "read": 0.05}),
    "plot.validation.misprints": lambda: dict(
        deviation=[1e-9, 0.8], names=["b11", "b12"]
    ),
    "orientation.textbook.intersection": lambda: dict(
        stations=[(0.0, 0, 0), (4, 0, 0)], directions=[(0.0, 0, 1), (-2, 0, 1)]
    ),
    "orientation.textbook.resection": lambda: dict(
        start=(10.0, 5, 100, 0, 0, 0.3), points=POINTS, c=35.0,
        image=camera.textbook.project(PHOTO, POINTS, 35.0),
    ),
    "plot.studies.residuals_by_photo": lambda: dict(
        rms={"a": [1.0, 2], "b": [2.0, 3]}, photo_names=["p", "q"]
    ),
    "plot.studies.predicted_against_sampled": lambda: dict(
        predicted=[1.0, 2], sampled={"a": [1.5, 2]}, names=["c", "x0"], samples=20
    ),
    "plot.studies.size_study": lambda: dict(
        rays=[10.0, 100], seconds={"a": [1.0, 2]}, megabytes=[1.0, 2],
        labels=["s", "t"],
    ),
    "registration.accuracy": lambda: dict(dx=[0.5, -0.25, 0.1], dy=[0.0, 1.0, 0.2]),
    "registration.Accuracy.times": lambda: dict(
        self=registration.accuracy([0.5, -0.25], [0.0, 1.0]), pixel_size=(2.0, 3.0)
    ),
    "registration.fit": lambda: dict(found=registered(), offset=(1.0, 2.0)),
    "registration.grid": lambda: dict(shape=(48, 44), step=5),
    "registration.Model.apply": lambda: dict(
        self=registration.fit(registered()), points=[(1.0, 2), (3, 4)]
    ),
    "registration.offset": lambda: dict(reference=raster(), sensed=raster()),
    "registration.pick": lambda: dict(
        image=GREY, number=3, chip=11, sensed=GREY, offset=(0.5, 1.0)
    ),
    "registration.Raster.map": lambda: dict(self=raster(), pixels=[(1.0, 2), (3, 4)]),
    "registration.Raster.pixels": lambda: dict(
        self=raster(), map_points=[(1.0, 2), (3, 4)]
    ),
    "registration.Raster.with_values": lambda: dict(self=raster(), values=GREY),
    "registration.resample": lambda: dict(
        sensed=GREY, model=registration.fit(registered()), shape=(40, 50)
    ),
    "registration.register": lambda: dict(
        reference=GREY, sensed=GREY, points=[(20, 20), (26, 22)], chip=11,
        refine="lsm", largest_sd=0.5, offset=(0.0, 0.0), nodata=0.0,
    ),
    "rotation.matrix": lambda: dict(ANGLES),
    "rotation.derivatives": lambda: dict(ANGLES),
    "rotation.small_angle": lambda: dict(ANGLES),
    "rotation.angles": lambda: dict(EYE),
    "rotation.is_gimbal": lambda: dict(EYE),
    "rotation.from_tilt_azimuth_swing": lambda: dict(
        tilt=0.5, azimuth=0.25, swing=0.125
    ),
    "rotation.to_tilt_azimuth_swing": lambda: dict(
        M=np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
    ),
    "rotation.from_quaternion": lambda: dict(quaternion=(1.0, 0, 0, 0)),
    "rotation.to_quaternion": lambda: dict(EYE),
    "rotation.from_rodrigues": lambda: dict(vector=(0.5, 0.25, 0.125)),
    "rotation.to_rodrigues": lambda: dict(EYE),
    "rotation.angle_between": lambda: dict(first=MATRIX, second=np.eye(3)),
    "rotation.defect": lambda: dict(EYE),
    "rotation.nearest": lambda: dict(EYE),
    "rotation.best_fit": lambda: dict(product=NET),
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
    "stereo.y_parallax": lambda: dict(
        pair=epipolar_pair(), points=[(20.0, 20), (26, 22)]
    ),
    "stereo.match_dense": lambda: dict(pair=normal_pair()),
    "stereo.match_rows": lambda: dict(left=GREY, right=GREY, search=5),
    "stereo.intersect": lambda: dict(pair=normal_pair(), match=dense_match()),
    "stereo.surface": lambda: dict(
        points=POINTS, cell=2.0, extent=(0.0, -10, 30, 15), largest_gap=20.0
    ),
    "stereo.filter_terrain": lambda: dict(dsm=hilly_surface()),
    "stereo.quality": lambda: dict(
        heights=[1.0, 2, 4], truth=[1.0, 2, 3], where=[True, False, True]
    ),
    "stereo.save_points": lambda: dict(
        points=object_points(), path=new_file(), overwrite=True
    ),
    "stereo.save_surface": lambda: dict(
        surface=hilly_surface(), path=new_file().with_suffix(".tif"), overwrite=True,
        crs="EPSG:32748",
    ),
    "stereo.neighbours": lambda: dict(photos=[oriented(), oriented()], ground=0.0),
    "stereo.textbook.model_point": lambda: dict(
        x=1.0, y=2.0, parallax=8.0, base=400.0, c=24.0
    ),
    "stereo.textbook.epipolar_line": lambda: dict(
        base=(5.0, 0, 0), ray=(1.0, 2, -9), M=MATRIX, c=24.0
    ),
    "stereo.textbook.best_disparity": lambda: dict(
        left=GREY, right=GREY, column=20, row=20, window=7, low=-5, high=5
    ),
    "stereo.textbook.along_row": lambda: dict(
        left=GREY, right=GREY, column=20, row=20, window=7, low=-5, high=5
    ),
    "stereo.textbook.sigma_height": lambda: dict(H=1e3, B=4e2, gsd=0.2, sigma_px=0.1),
    "stereo.textbook.row_points": lambda: dict(
        pair=normal_pair(), row=30, columns=[25, 30], window=7, low=-5, high=5
    ),
    "stereo.textbook.coarser": lambda: dict(pair=normal_pair()),
    "simulate.Texture": lambda: dict(
        frequencies=np.array([(0.25, 0.0)]), amplitudes=np.array([10.0]),
        phases=np.zeros(1), mean=100.0,
    ),
    "simulate.control_photo": lambda: dict(PHOTOS),
    "simulate.pair": lambda: dict(PHOTOS),
    "simulate.rotations": lambda: dict(rng=rng(), n=4),
    "simulate.rough": lambda: dict(
        exterior=(0.0, 0, 10, 0, 0, 0), rng=rng(), degrees=30.0, share=0.5
    ),
    "simulate.network": lambda: dict(
        lens=LENS, photos=4, points=6, rng=rng(), rays=3.0
    ),
    "simulate.on_relief": lambda: SCENE | dict(image_points=[(0.0, 0), (1, 1.5)]),
    "simulate.relief_photo": lambda: SCENE | dict(
        texture=simulate.texture(waves=20), image_size=(4, 3), pixel_size=0.5
    ),
    "simulate.photograph": lambda: dict(image=GREY[:3, :3], noise=1.0, seed=1, bits=8),
    "simulate.target": lambda: dict(centre=(10.25, 9.5)),
    "simulate.landscape": lambda: dict(
        extent=(-8.0, -5, 8, 5), cell=0.5, buildings=1, trees=1, borders=(-2.0, 2)
    ),
    "simulate.Landscape.at": lambda: dict(
        self=simulate.landscape((-8.0, -5, 8, 5), cell=0.5), layer=np.ones((20, 32)),
        X=[0.0, 1], Y=[1.0, 2],
    ),
    "simulate.Landscape.zone": lambda: dict(
        self=simulate.landscape((-8.0, -5, 8, 5), cell=0.5), X=[0.0, 5]
    ),
    "simulate.aerial_pair": lambda: dict(
        part=(24, 16), cell=0.5, buildings=1, trees=1, camera=LENS
    ),
    "simulate.aerial_block": lambda: dict(
        strips=1, photos=2, part=(24, 16), cell=0.5, buildings=1, trees=1, camera=LENS
    ),
    "simulate.ortho_pair": lambda: dict(
        scene=GREY + 10, shift=(1, 2), factor=2, blur=0.5, haze=0.2, changed=0.5,
        dtype=np.uint16,
    ),
    "simulate.shrunk_pair": lambda: dict(image=GREY, shift=(1, 2), factor=2),
    "simulate.texture": lambda: dict(waves=20),
    "simulate.texture_pair": lambda: dict(
        texture=simulate.texture(waves=20), shape=(6, 8),
        affine=(3.0, 1, 0, 2, 0, 1), dtype=np.uint8,
    ),
    "simulate.grey_values": lambda: dict(texture=simulate.texture(waves=9), points=UP),
    "simulate.grey_gradients": lambda: dict(
        texture=simulate.texture(waves=9), points=UP
    ),
}  # fmt: skip


def fresh(arguments):
    """Copies of arguments that a call may change."""
    kinds = np.ndarray | np.random.Generator | list | dict | tuple
    return {
        name: copy.deepcopy(one) if isinstance(one, kinds) else one
        for name, one in arguments.items()
    }


def of(name, function):
    """Good arguments of a function, with its defaults."""
    given = FUNCTIONS[name]()
    defaults = {
        key: one.default
        for key, one in inspect.signature(function).parameters.items()
        if one.default is not one.empty and isinstance(one.default, _PLAIN)
    }
    return defaults | given


_PLAIN = bool | int | float | str | tuple | list
