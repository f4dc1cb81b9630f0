"""How often an orientation converges to the truth, over 1000 random cases a row.

(Relative orientation, which takes longer: over 250.)

``python -m pgm_book.ch05.studies.convergence`` writes results/convergence.csv in some
minutes; tests/ch05/test_convergence.py repeats a part.
"""

import numpy as np
from tqdm import tqdm

from pgm_book.common import study
from pgm_lab import simulate
from pgm_lab.adjustment import adjust
from pgm_lab.camera import Camera, imaging, project
from pgm_lab.orientation import intersect, relative, resect

CAMERA = Camera(35.0)
SIGMA = 0.002
DEGREES, SHARE = 30, 0.5
# Squared Mahalanobis distance from the truth that six unknowns exceed once in 1e9.
FAR = 53.0
COLUMNS = (
    *("problem", "points", "object", "start", "method"),
    *("cases", "converged", "several_solutions"),
)
FAR_OFF = "30 degrees and half the distance off"


def resection(n: int, flat: bool, cases: int) -> list[tuple]:
    """Rows of the table for resection from n points."""
    rng = np.random.default_rng([5, n, flat])
    photos = [
        simulate.control_photo(CAMERA, n, rng, flat, SIGMA)
        for _ in tqdm(range(cases), f"resection, {n} points", leave=False)
    ]
    truth, points, image = (np.array(part) for part in zip(*photos, strict=True))
    starts = np.array([simulate.rough(x, rng, DEGREES, SHARE) for x in truth])

    def collinearity(x, points, image):
        v, _, blocks = imaging.misclosure(
            CAMERA.interior, x[:, None], points, image, CAMERA.lens, ("exterior",)
        )
        return v.reshape(len(x), -1), blocks["exterior"].reshape(len(x), -1, 6)

    def alone(line_search):
        found = adjust(
            collinearity,
            starts,
            np.zeros(2 * n),
            args=(points, image),
            weights=np.full(2 * n, SIGMA**-2),
            line_search=line_search,
        )
        ok = found.status == "converged"
        return ok & reached(found.x, truth, found.cofactor), 0

    def ours(start):
        found = [
            resect(CAMERA, *case, start=x, sigma=SIGMA)
            for case, x in zip(zip(image, points), start)
        ]
        several = np.sum([f.status == "several solutions" for f in found])
        exterior = np.array([f.exterior for f in found])
        Q = np.array([f.covariance for f in found])
        return reached(exterior, truth, Q), several

    kind = "flat" if flat else "spatial"
    return [
        ("resection", n, kind, start, method, cases, np.sum(success), several)
        for start, method, (success, several) in (
            ("none", "resect", ours([None] * cases)),
            (FAR_OFF, "resect", ours(starts)),
            (FAR_OFF, "adjustment with line search alone", alone(True)),
            (FAR_OFF, "adjustment with full steps", alone(False)),
        )
    ]


def intersection(p: int, cases: int) -> list[tuple]:
    """Rows of the table for intersection of one point from p photos."""
    rng = np.random.default_rng([55, p])
    photos, points, image = [], [], []
    for _ in range(cases):
        x = rng.uniform(-40, 40, (p, 6))
        x[:, 2] = rng.uniform(80, 120, p)
        x[:, 3:5] = rng.uniform(-0.2, 0.2, (p, 2))
        photos.append(x)
        points.append(rng.uniform(-20, 20, 3))
        error = SIGMA * rng.normal(size=(p, 2))
        image.append(project(CAMERA, x, points[-1]) + error)
    photos, points, image = map(np.array, (photos, points, image))
    distance = np.linalg.norm(points - photos[:, :, :3].mean(axis=1), axis=1)
    aside = rng.normal(size=(cases, 3))
    aside *= SHARE * (distance / np.linalg.norm(aside, axis=1))[:, None]

    def collinearity(x, photos, image):
        v, _, blocks = imaging.misclosure(
            CAMERA.interior, photos, x[:, None], image, CAMERA.lens, ("point",)
        )
        return v.reshape(len(x), -1), blocks["point"].reshape(len(x), -1, 3)

    def alone(line_search):
        found = adjust(
            collinearity,
            points + aside,
            np.zeros(2 * p),
            args=(photos, image),
            weights=np.full(2 * p, SIGMA**-2),
            line_search=line_search,
        )
        ok = found.status == "converged"
        return ok & reached(found.x, points, found.cofactor)

    found = [intersect(CAMERA, *case, sigma=SIGMA) for case in zip(photos, image)]
    X, Q = (np.array([getattr(f, a) for f in found]) for a in ("points", "covariance"))
    return [
        ("intersection", 1, f"{p} photos", start, method, cases, np.sum(success), 0)
        for start, method, success in (
            ("none", "intersect", reached(X, points, Q)),
            ("half the distance off", "adjustment with line search alone", alone(True)),
            ("half the distance off", "adjustment with full steps", alone(False)),
        )
    ]


def relative_orientation(n: int, flat: bool, cases: int) -> list[tuple]:
    """Rows of the table for relative orientation from n points.

    It has converged when the model that the truth itself leads to is among the
    solutions: noise may make another one fit as well, above all with flat objects.
    """
    rng = np.random.default_rng([555, n, flat])
    success = {"none": [], FAR_OFF: []}
    given = {"base": 1.0, "sigma": SIGMA}
    for _ in tqdm(range(cases), f"relative, {n} points", leave=False):
        truth, left, right = simulate.pair(CAMERA, n, rng, flat, SIGMA)
        start = simulate.rough(truth, rng, DEGREES, SHARE)[1:]
        images = CAMERA, CAMERA, left, right
        best = among(relative, *images, start=truth[1:], **given)[:1]
        for name, x in (("none", None), (FAR_OFF, start)):
            found = among(relative, *images, start=x, **given)
            same = len(best) > 0 and bool(np.any(close(found, best)))
            success[name].append((same, len(found) > 1))
    kind = "flat" if flat else "spatial"
    return [
        ("relative orientation", n, kind, start, "relative", cases, *np.sum(count, 0))
        for start, count in success.items()
    ]


def among(method, *arguments, **options) -> np.ndarray:
    """Solutions (k, 6) of an orientation; none if it is refused."""
    try:
        return method(*arguments, **options).solutions
    except ValueError:
        return np.empty((0, 6))


def close(solutions: np.ndarray, exterior: np.ndarray) -> np.ndarray:
    """Which solutions (k, 6) are the one wanted, to 1e-4 in every element."""
    off = solutions - exterior
    off[:, 3:] = (off[:, 3:] + np.pi) % (2 * np.pi) - np.pi
    return np.all(np.abs(off) < 1e-4, axis=1)


def reached(x: np.ndarray, truth: np.ndarray, Q: np.ndarray) -> np.ndarray:
    """Whether x is the truth, as far as its covariance can tell."""
    e = x - truth
    if e.shape[-1] > 4:
        e[..., -3:] = (e[..., -3:] + np.pi) % (2 * np.pi) - np.pi
    known = np.all(np.isfinite(e), axis=-1) & np.all(np.isfinite(Q), axis=(-2, -1))
    e, Q = np.where(known[..., None], e, 1e9), np.where(known[..., None, None], Q, 0)
    u = e.shape[-1]
    Q = Q + np.where(known, 0.0, 1.0)[..., None, None] * np.eye(u)
    return (
        np.einsum("...i,...i->...", e, np.linalg.solve(Q, e[..., None])[..., 0]) < FAR
    )


def rows(cases: int) -> list[tuple]:
    """Return the whole table."""
    table = []
    for n in (4, 6, 10):
        for flat in (False, True):
            table += resection(n, flat, cases)
    for p in (2, 4):
        table += intersection(p, cases)
    for n in (6, 10):
        for flat in (False, True):
            table += relative_orientation(n, flat, cases // 4)
    return table


if __name__ == "__main__":
    study.write("ch05", "convergence", COLUMNS, rows(1000))
