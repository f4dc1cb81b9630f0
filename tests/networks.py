"""Small networks for the tests of the bundle adjustment, and its dense twin."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from pgm_lab import adjustment, bundle, camera, datasets, rotation
from pgm_lab.bundle import dense as textbook
from pgm_lab.camera import PARAMETERS, Camera
from pgm_lab.datasets import EXTERIOR, XYZ, _columns, _image_points

LENS = {"K1": 3e-5, "P1": 1e-5, "P2": -2e-5, "b1": 2e-4}


def real():
    """The network of Muliawan 2013: nine photos of fifty points."""
    data = datasets.muliawan2013()
    start = Camera(*data.interior), data.exteriors, data.object_points
    return bundle.Network(*start, data.photo, data.point, data.xy, data.sigma)


def jaicov_9x50():
    """Nine photos of fifty targets, which JAICOV, a program in Java, has adjusted.

    A free network with inner constraints on all points, lens "forward": start values,
    what JAICOV found, and its standard deviations, in the order of its tables.
    """
    name = "jaicov_9x50_{}.csv".format
    photo, point, xy, sigma = _image_points(name("image_points"))
    interior, interior_sd = _columns(name("interior"), "value", "sd").T
    of_photo, of_point = name("exterior"), name("object_points")
    return SimpleNamespace(
        photo=photo,
        point=point,
        xy=xy,
        sigma=sigma,
        interior=np.array([35.4] + [0.0] * 9),
        exteriors=_columns(name("start_exterior"), *EXTERIOR),
        points=_columns(name("start_object_points"), *XYZ),
        adjusted_interior=interior,
        adjusted_exteriors=_columns(of_photo, *EXTERIOR),
        adjusted_points=_columns(of_point, *XYZ),
        interior_sd=interior_sd,
        exteriors_sd=_columns(of_photo, *(f"sd_{axis}" for axis in EXTERIOR)),
        points_sd=_columns(of_point, *(f"sd_{axis}" for axis in XYZ)),
        variance=0.9487167938,
        redundancy=693,
    )


def small(lens="backward", photos=6, points=12, cameras=1, sigma=0.001, seed=3, skip=0):
    """Convergent photos from all sides, rolled, with start values that are off."""
    rng = np.random.default_rng(seed)
    X = rng.uniform(-300, 300, (points, 3)) * [1, 1, 0.4]
    round_about = np.linspace(0, 2 * np.pi, photos, endpoint=False) + 0.3
    exteriors = []
    for i, angle in enumerate(round_about):
        centre = np.array([900 * np.cos(angle), 700 * np.sin(angle), 900 + 60 * i])
        axis = centre / np.linalg.norm(centre)
        right = np.cross([0.1, 0.2, 1.0], axis)
        right /= np.linalg.norm(right)
        M = np.array([right, np.cross(axis, right), axis])
        M = rotation.matrix(0, 0, i * np.pi / 2) @ M
        exteriors.append([*centre, *rotation.angles(M)])
    exteriors = np.array(exteriors)
    lenses = [Camera(30.0 + i, 0.1, -0.2, **LENS, lens=lens) for i in range(cameras)]
    photo, point = np.divmod(np.arange(photos * points), points)
    kept = rng.permutation(len(photo))[skip:]
    photo, point = photo[kept], point[kept]
    of_photo = np.arange(photos) % cameras
    xy = np.empty((len(photo), 2))
    for i, lens_of in enumerate(of_photo):
        seen = photo == i
        xy[seen] = camera.project(lenses[lens_of], exteriors[i], X[point[seen]])
    sigma = sigma * rng.uniform(0.7, 1.5, xy.shape)
    return bundle.Network(
        [Camera(one.c * 1.02, lens=lens) for one in lenses],
        exteriors + rng.normal(size=exteriors.shape) * [9, 9, 9, 0.01, 0.01, 0.01],
        X + 3 * rng.normal(size=X.shape),
        photo,
        point,
        xy + sigma * rng.normal(size=xy.shape),
        sigma,
        camera=of_photo,
    )


def dense(network, estimate, constraint=None, free=None, **options):
    """The same adjustment by the dense core: all unknowns in one normal matrix.

    `constraint(exteriors, points)` returns the rows of inner constraints, on exterior
    orientations (k, m, 6) and points (k, n, 3).
    """
    columns = [PARAMETERS.index(name) for name in estimate]
    u, m, n = len(columns), len(network.exteriors), len(network.points)
    U = u * len(network.cameras)
    lens, start = network.cameras[0].lens, network.points.copy()
    free = np.ones(3 * n, bool) if free is None else free.ravel()
    kept = np.concatenate([np.ones(U + 6 * m, bool), free])
    # the textbook's exterior orientations stand first, their angles before the centre
    exterior = 6 * np.arange(m)[:, None] + textbook.ANGLES_FIRST
    order = np.concatenate(
        [6 * m + np.arange(U), exterior.ravel(), 6 * m + U + np.arange(3 * n)]
    )

    def unpack(x):
        interior = network.interior.copy()
        interior[:, columns] = x[:U].reshape(len(interior), u)
        points = start.ravel().copy()
        points[free] = x[U + 6 * m :]
        return interior, x[U : U + 6 * m].reshape(m, 6), points.reshape(n, 3)

    def function(x):
        interior, exteriors, points = unpack(x)
        photo, point = network.photo, network.point
        v, A1, A3, A2 = textbook.derivatives(
            interior[network.camera], exteriors, points, photo, point, network.xy, lens
        )
        A3 = A3[..., columns]
        A = textbook.design(A1, A3, A2, photo, point, m, n, network.camera)[:, order]
        values, A = [v.ravel()], [A]
        for a, b, distance, _ in network.scale_bars:
            a, b = int(a), int(b)
            difference = points[b] - points[a]
            values.append([np.linalg.norm(difference) - distance])
            row = np.zeros((1, U + 6 * m + 3 * n))
            unit = difference / np.linalg.norm(difference)
            row[0, U + 6 * m + 3 * b : U + 6 * m + 3 * b + 3] = unit
            row[0, U + 6 * m + 3 * a : U + 6 * m + 3 * a + 3] = -unit
            A.append(row)
        return np.concatenate(values), np.concatenate(A)[:, kept]

    def inner(x):
        _, exteriors, points = unpack(x)
        of_exteriors, of_points = constraint(exteriors, points)
        d = len(of_points)
        parts = [np.zeros((d, U)), of_exteriors.reshape(d, -1)]
        rows = np.concatenate([*parts, of_points.reshape(d, -1)], axis=1)
        return np.zeros(d), rows[:, kept]

    x = np.concatenate(
        [network.interior[:, columns].ravel(), network.exteriors.ravel(), start.ravel()]
    )[kept]
    sigmas = [network.sigma.ravel(), network.scale_bars[:, 3]]
    if "covariance" not in options:
        options["weights"] = np.concatenate(sigmas) ** -2.0
    found = adjustment.adjust(
        function,
        x,
        np.zeros(2 * len(network.xy) + len(network.scale_bars)),
        constraints=None if constraint is None else inner,
        tolerance=1e-9,
        **options,
    )
    return found, unpack(found.x), kept


def G(points):
    """Rows (7, n, 3) of the shifts, turns and scale of points, (M 2.95) transposed."""
    return textbook.G(points).T.reshape(7, -1, 3)


def moved(network, scale, turn, shift):
    """The network in another object frame: scale * turn @ X + shift."""
    exteriors = network.exteriors.copy()
    exteriors[:, :3] = scale * exteriors[:, :3] @ turn.T + shift
    M = rotation.matrix(*network.exteriors[:, 3:].T) @ turn.T
    exteriors[:, 3:] = rotation.angles(M)
    return replace(
        network, exteriors=exteriors, points=scale * network.points @ turn.T + shift
    )
