"""Questions with numbers on rays and adjustments: lessons A1, 4, 5, 6, 8 and 9."""

import numpy as np

from pgm_book.course.numbers import Chance, Numbers, listed, matrix, total
from pgm_book.program import bundle as lens
from pgm_book.program.adjustment import adjust, ellipse, redundancy_numbers
from pgm_book.program.camera import project
from pgm_book.program.orientation import intersection
from pgm_book.program.stereo import model_point, sigma_height
from pgm_book.program.surface import base_length
from pgm_lab import rotation
from pgm_lab.orientation import coplanarity
from pgm_lab.stereo.heights import quality

# --- A1: least squares adjustment ---


def weighted_mean(draw: Chance) -> Numbers:
    """Weighted mean."""
    H = draw(95, 105, 0.1)
    heights = np.round(H + draw.several(3, -9, 9) / 1000, 3)
    km = draw.several(3, 0.4, 6, 0.2)
    x, *_ = adjust(np.ones((3, 1)), 1 / km, heights)
    given = dict(
        h=listed(heights, "%.3f"),
        km=listed(km),
        p=listed(1 / km, "%.4f"),
        sum=np.sum(1 / km),
    )
    slips = [
        float(np.average(heights, weights=km)),
        heights.mean(),
        float(np.average(heights, weights=km ** (-2))),
    ]
    return given, x[0], slips


def mean_sd(draw: Chance) -> Numbers:
    """Precision of a mean."""
    s = draw.several(3, 1, 6, 0.1)
    answer = 1 / np.sqrt(np.sum(s**-2))
    return (
        dict(s=listed(s), w=listed(s ** (-2), "%.4f"), sum=np.sum(s ** (-2))),
        answer,
        [s.min(), np.linalg.norm(s) / 3, s.mean()],
    )


def net_redundancy(draw: Chance) -> Numbers:
    """Redundancy of a levelling net."""
    points, known = draw(6, 20), draw(1, 3)
    lines = points + draw(2, 20)
    given = dict(points=points, known=known, lines=lines, u=points - known)
    slips = [lines - points, lines - known, lines - points - known]
    return given, lines - points + known, slips


def sigma0(draw: Chance) -> Numbers:
    """The sigma0 of an adjustment."""
    v, km, u = (
        draw.several(5, -6, 6, 0.1),
        draw.several(5, 0.5, 4, 0.5),
        draw.of([2, 3]),
    )
    pvv = np.sum(v**2 / km)
    answer = np.sqrt(pvv / (5 - u))
    return (
        dict(v=listed(v), km=listed(km), u=u, pvv=pvv, r=5 - u),
        answer,
        [np.sqrt(pvv / 5), np.sqrt(pvv / 4), np.linalg.norm(v) / np.sqrt(5 - u)],
    )


def redundancy_number(draw: Chance) -> Numbers:
    """Redundancy number."""
    km = draw.several(3, 0.5, 8, 0.5)
    p = 1 / km
    r = redundancy_numbers(np.ones((3, 1)), p)[0]
    given = dict(km=listed(km), first=km[0], p=p[0], sum=p.sum())
    return given, r, [1 - r, 1 - km[0] / km.sum(), 2 / 3]


def baarda(draw: Chance) -> Numbers:
    """Baarda's w."""
    v, s, r = draw(3, 20, 0.1), draw(1, 4, 0.1), draw(0.15, 0.75, 0.01)
    w = v / s / np.sqrt(r)
    return dict(v=v, s=s, r=r), w, [v / s, v / s / r, w * r]


def blunder(draw: Chance) -> Numbers:
    """A blunder and its residual."""
    r, dv = draw(0.08, 0.75, 0.01), draw(2, 15, 0.1)
    return dict(r=r, dv=dv), dv / r, [dv * r, dv / (1 - r), dv / np.sqrt(r)]


def error_ellipse(draw: Chance) -> Numbers:
    """Error ellipse."""
    a, b = draw(6, 40, 0.5), draw(6, 40, 0.5)
    c = round(draw.of([-1, 1]) * draw(0.2, 0.85, 0.05) * np.sqrt(a * b), 1)
    long, short, _ = ellipse(np.array([[a, c], [c, b]]))
    root = np.hypot((a - b) / 2, c)
    given = dict(C=matrix([[a, c], [c, b]]), a=a, b=b, c=c, mean=(a + b) / 2, root=root)
    return given, long, [short, long**2, np.sqrt(max(a, b))]


# --- 4: rotation matrices ---


def plane_rotation(draw: Chance) -> Numbers:
    """Rotate the frame."""
    X, Y, k = draw(5, 60, 0.1), draw(5, 60, 0.1), draw(8, 80) * draw.of([-1, 1])
    M = rotation.matrix(0, 0, np.radians(k))
    x, y, _ = M @ (X, Y, 0)
    given = dict(X=X, Y=Y, k=k)
    return given, x, [(M.T @ (X, Y, 0))[0], X * np.cos(k) + Y * np.sin(k), y]


def element(draw: Chance) -> Numbers:
    """An element of M."""
    o, f, k = draw.several(3, 8, 55)
    M = rotation.matrix(*np.radians([o, f, k]))
    reverse = np.linalg.multi_dot(
        [rotation.matrix(*np.radians(one)) for one in ((o, 0, 0), (0, f, 0), (0, 0, k))]
    )
    given = dict(o=o, f=f, k=k)
    return given, M[0, 1], [M[1, 0], rotation.matrix(o, f, k)[0, 1], reverse[0, 1]]


def omega(draw: Chance) -> Numbers:
    """Omega, in every quadrant."""
    o = np.radians(draw(95, 170)) * draw.of([-1, 1])
    M = rotation.matrix(o, np.radians(draw(-30, 30)), np.radians(draw(-60, 60)))
    m32, m33 = np.round(M[2, 1:], 4)
    answer = np.degrees(np.arctan2(-m32, m33))
    return (
        dict(m32=m32, m33=m33),
        answer,
        [np.degrees(np.arctan(-m32 / m33)), -answer, np.radians(answer)],
    )


def tilt(draw: Chance) -> Numbers:
    """Tilt of a photo."""
    o, f = draw(8, 40), draw(8, 40)
    M = rotation.matrix(*np.radians([o, f, 0]))
    answer = np.degrees(rotation.to_tilt_azimuth_swing(M)[0])
    return dict(o=o, f=f), answer, [np.hypot(o, f), o + f, np.radians(answer)]


def whole_angle(draw: Chance) -> Numbers:
    """Angle of a rotation."""
    M = rotation.matrix(*np.radians(draw.several(3, -50, 50)))
    diagonal = np.round(np.diag(M), 4)
    trace = diagonal.sum()
    answer = np.degrees(np.arccos((trace - 1) / 2))
    return (
        dict(d=listed(diagonal, "%.4f"), trace=trace),
        answer,
        [
            np.degrees(np.arccos(trace / 3)),
            np.radians(answer),
            np.degrees(np.arccos(np.clip(trace - 2, -1, 1))),
        ],
    )


def small_kappa(draw: Chance) -> Numbers:
    """A small error of kappa."""
    k, x, p = draw(0.02, 0.5, 0.01), draw(4, 18, 0.1), draw(3, 9, 0.01)
    answer = x * np.radians(k) / p * 1000
    return dict(k=k, x=x, p=p), answer, [x * k / p * 1000, answer / 2, answer * 0.9]


def nadir(draw: Chance) -> Numbers:
    """Nadir point."""
    c, t = draw.of([18, 24, 35, 50, 153]), draw(4, 35, 0.5)
    down = rotation.matrix(np.radians(t), 0, 0) @ (0, 0, -1)
    answer = c * abs(down[1] / down[2])
    return (
        dict(c=c, t=t),
        answer,
        [
            c * np.sin(np.radians(t)),
            c * np.tan(np.radians(t / 2)),
            c * np.radians(t),
            c * abs(np.tan(t)),
        ],
    )


def quaternion(draw: Chance) -> Numbers:
    """Angle in a quaternion."""
    q = draw.several(4, -9, 9)
    q[0] = draw(3, 9)
    R = rotation.from_quaternion(q / np.linalg.norm(q))
    answer = np.degrees(rotation.angle_between(R, np.eye(3)))
    return (
        dict(q=listed(q), w=q[0], n2=int(q @ q)),
        answer,
        [
            answer / 2,
            np.radians(answer),
            2 * np.degrees(np.arccos(min(q[0] / np.abs(q).sum(), 1))),
        ],
    )


# --- 5: intersection ---


def collinearity(draw: Chance) -> Numbers:
    """A photo coordinate."""
    c, H = draw.of([24, 35, 153]), draw(600, 1500, 10)
    k, X, Y = draw(15, 75), draw(80, 300), draw(80, 300)
    exterior = np.array([0, 0, H, 0, 0, np.radians(k)])
    x, y = project(exterior, np.array([[X, Y, 0]]), c)[0]
    other = project(exterior * [1, 1, 1, 1, 1, -1], np.array([[X, Y, 0]]), c)[0, 0]
    return dict(c=c, H=H, k=k, X=X, Y=Y, U=x * H / c), x, [other, -x, y]


def two_rays(draw: Chance) -> Numbers:
    """Two rays in a plane."""
    B, t1, t2 = draw(50, 400), draw(0.1, 0.7, 0.01), draw(-0.6, 0.05, 0.01)
    rays = np.array([[t1, 0, -1], [t2, 0, -1]])
    X, _, Z = intersection(np.array([[0, 0, 0], [B, 0, 0]]), rays)
    return dict(B=B, t1=t1, t2=t2), X, [-Z, X - B, t1 * B / (t1 + t2 or 9)]


def coplanar(draw: Chance) -> Numbers:
    """Coplanarity of two rays."""
    b = np.array([draw(2, 9), draw(-2, 2), draw(-2, 2)])
    u1 = np.array([draw(0.1, 0.9, 0.1), draw(-0.9, 0.9, 0.1), -1])
    u2 = np.array([draw(-0.9, 0.1, 0.1), draw(-0.9, 0.9, 0.1), -1])
    F = coplanarity.condition(b, np.eye(3), u1[None], u2[None])[0]
    given = dict(
        b=listed(b),
        u1=listed(u1),
        u2=listed(u2),
        n=listed(np.round(np.cross(u1, u2), 4)),
    )
    slips = [
        -F,
        float(
            b @ (np.roll(u1, -1) * np.roll(u2, -2) + np.roll(u1, -2) * np.roll(u2, -1))
        ),
        float(b[0] * np.cross(u1, u2)[0]),
    ]
    return given, F, slips


def intersection_redundancy(draw: Chance) -> Numbers:
    """Redundancy of an intersection."""
    photos, points = draw(2, 7), draw(3, 40)
    given = dict(photos=photos, points=points, n=2 * photos * points, u=3 * points)
    slips = [
        points * (photos - 3),
        points * (2 * photos - 2),
        points * (2 * photos - 3) - 6 * photos,
    ]
    return given, points * (2 * photos - 3), slips


def relative_redundancy(draw: Chance) -> Numbers:
    """Redundancy of a relative orientation."""
    n, wrong = draw(9, 90), draw(1, 3)
    given = dict(n=n, wrong=wrong, left=n - wrong)
    return given, n - wrong - 5, [n - wrong - 6, n - 5, 2 * (n - wrong) - 5]


def height_sd(draw: Chance) -> Numbers:
    """Precision of an intersected height."""
    c, H, s = draw.of([24, 35, 100, 153]), draw(300, 2000, 10), draw(1, 8, 0.5)
    B = draw(round(0.25 * H / 10) * 10, round(0.7 * H / 10) * 10, 10)
    answer = H / B * H / c * np.sqrt(2) * s / 10
    return (
        dict(c=c, H=H, s=s, B=B),
        answer,
        [answer / np.sqrt(2), H / c / np.sqrt(2) * s / 10, H / c * np.sqrt(2) * s / 10],
    )


def model_scale(draw: Chance) -> Numbers:
    """Scale of a model."""
    a, b = draw.several(3, -9, -1, 0.1), draw.several(3, 1, 9, 0.1)
    D = draw(30, 200, 0.1)
    d = np.linalg.norm(b - a)
    slips = [d / D, D / np.linalg.norm((b - a)[:2]), D / np.abs(b - a).sum()]
    return dict(a=listed(a), b=listed(b), D=D, d=d), D / d, slips


def to_ground(draw: Chance) -> Numbers:
    """From the model to the ground."""
    s, k = draw(2, 30, 0.1), draw(15, 80)
    x, y, T = draw(2, 9, 0.1), draw(2, 9, 0.1), draw(1000, 5000)
    R = rotation.matrix(0, 0, np.radians(k)).T
    answer = s * (R @ (x, y, 0))[0] + T
    return (
        dict(s=s, k=k, x=x, y=y, T=T),
        answer,
        [
            s * (R.T @ (x, y, 0))[0] + T,
            s * ((R @ (x, y, 0))[0] + T),
            (R @ (x, y, 0))[0] + T,
        ],
    )


# --- 6: self-calibrating bundle adjustment ---


def bundle_redundancy(draw: Chance) -> Numbers:
    """Redundancy of a bundle."""
    m, n, lost = draw(5, 20), draw(20, 90), draw(0, 40)
    rays = m * n - lost
    u = 10 + 6 * m + 3 * n
    given = dict(m=m, n=n, rays=rays, u=u)
    return given, 2 * rays - u + 7, [2 * rays - u, rays - u + 7, 2 * rays - u + 17]


def zeros(draw: Chance) -> Numbers:
    """Zeros of the normal matrix."""
    m, n, p = draw(4, 20), draw(15, 90), draw(3, 10)
    size = p + 6 * m + 3 * n
    empty = 36 * m * (m - 1) + 9 * n * (n - 1)
    answer = 100 * empty / size**2
    return (
        dict(m=m, n=n, p=p, size=size, a=36 * m * (m - 1), b=9 * n * (n - 1)),
        answer,
        [
            900 * n * (n - 1) / size**2,
            100 - answer,
            100 * (36 * m * m + 9 * n * n) / size**2,
        ],
    )


def radial(draw: Chance) -> Numbers:
    """Radial distortion."""
    x, y = draw(3, 10, 0.1), draw(3, 8, 0.1)
    K1, K2 = draw(-9, -3, 0.1), draw(2, 6, 0.1)
    camera = [35, 0, 0, K1 * 1e-5, K2 * 1e-8, 0, 0, 0, 0, 0]
    dx, dy = 1000 * (lens.without_lens(np.array([[x, y]]), camera)[0] - (x, y))
    rho2 = x * x + y * y
    slips = [
        dy,
        np.hypot(dx, dy),
        1000.0 * x * (K1 * 1e-05 * rho2**0.5 + K2 * 1e-08 * rho2),
        -dx,
    ]
    return dict(x=x, y=y, K1=K1, K2=K2, rho2=rho2, f=dx / x), dx, slips


def decentring(draw: Chance) -> Numbers:
    """Decentring distortion."""
    x, y = draw(3, 11, 0.1), draw(-8, -3, 0.1)
    P1, P2 = draw(2, 9, 0.1), draw(2, 9, 0.1)
    camera = [35, 0, 0, 0, 0, 0, P1 * 1e-5, P2 * 1e-5, 0, 0]
    dx, dy = 1000 * (lens.without_lens(np.array([[x, y]]), camera)[0] - (x, y))
    rho2 = x * x + y * y
    a, b = 0.01 * P1 * (rho2 + 2 * x * x), 0.02 * P2 * x * y  # µm
    given = dict(x=x, y=y, P1=P1, P2=P2, rho2=rho2, a=a, b=b)
    return given, dx, [dy, a - 0.01 * P1 * rho2 + b, a + b / 2, a - b]


def correlated(draw: Chance) -> Numbers:
    """A sum of correlated terms."""
    a, b, r = draw(3, 9, 0.1), draw(3, 9, 0.1), -draw(0.8, 0.98, 0.01)
    C = np.array([[a * a, r * a * b], [r * a * b, b * b]])
    answer = np.sqrt(C.sum())
    return (
        dict(a=a, b=b, r=r),
        answer,
        [
            np.hypot(a, b),
            np.sqrt(a * a + b * b + r * a * b),
            np.sqrt(a * a + b * b - 2 * r * a * b),
        ],
    )


def two_halves(draw: Chance) -> Numbers:
    """Two halves of a calibration."""
    s1, s2 = draw(15, 60), draw(15, 60)
    c1 = draw(34.8, 35.2, 0.001)
    c2 = round(c1 + draw(0.06, 0.2, 0.001), 3)
    answer = (c2 - c1) * 1000 / np.hypot(s1, s2)
    return (
        dict(s1=s1, s2=s2, c1=c1, c2=c2, d=(c2 - c1) * 1000, s=np.hypot(s1, s2)),
        answer,
        [(c2 - c1) * 1000 / (s1 + s2), (c2 - c1) * 1000 / s1, 2 * answer],
    )


def elimination(draw: Chance) -> Numbers:
    """What elimination saves."""
    m, n = draw(9, 30), draw(30, 120)
    small, whole = 10 + 6 * m, 10 + 6 * m + 3 * n
    answer = (whole / small) ** 3
    return (
        dict(m=m, n=n, small=small, whole=whole),
        answer,
        [whole / small, (whole / (6 * m)) ** 3, (whole / small) ** 2],
    )


def after(draw: Chance) -> Numbers:
    """Precision after the adjustment."""
    rays, m, n = draw(200, 900, 10), draw(5, 15), draw(20, 60)
    vv, s = draw(20, 400, 0.5), draw(0.5, 3, 0.1)
    r = 2 * rays - 10 - 6 * m - 3 * n + 7
    answer = np.sqrt(vv / r)
    return (
        dict(rays=rays, m=m, n=n, vv=vv, s=s, r=r),
        answer,
        [answer / s, np.sqrt(vv / (2 * rays)), vv / r],
    )


# --- 8: stereo plotting ---


def depth(draw: Chance) -> Numbers:
    """Depth from parallax."""
    c, B, p = draw.of([24, 35]), draw(150, 600), draw(6, 14, 0.01)
    x1 = draw(2, 9, 0.01)
    x2 = round(x1 - p, 2)
    Z = model_point(x1, 0, x1 - x2, B, c)[2]
    given = dict(c=c, B=B, x1=x1, x2=x2, p=x1 - x2)
    return given, -Z, [c * B / abs(x1 + x2 or 9), B * (x1 - x2) / c, c * B / x1]


def mast(draw: Chance) -> Numbers:
    """Height of a mast."""
    c, B = draw.of([24, 35, 50]), draw(200, 500)
    foot = draw(8, 12, 0.01)
    top = round(foot + draw(0.08, 0.6, 0.01), 2)
    Hf, Ht = c * B / foot, -model_point(0, 0, top, B, c)[2]
    given = dict(c=c, B=B, foot=foot, top=top, Hf=Hf, Ht=Ht)
    return given, Hf - Ht, [c * B / (top - foot), Hf / foot * (top - foot), Ht]


def sigma_z(draw: Chance) -> Numbers:
    """Precision of a height."""
    H, gsd, s = draw(400, 2000, 10), draw(0.05, 0.4, 0.005), draw(0.05, 0.8, 0.05)
    B = draw(round(0.025 * H) * 10, round(0.07 * H) * 10, 10)
    answer = sigma_height(H, B, gsd, s)
    return (
        dict(H=H, B=B, gsd=gsd, s=s),
        answer,
        [B / H * gsd * s, gsd * s, answer * np.sqrt(2)],
    )


def along_base(draw: Chance) -> Numbers:
    """Where the point lies."""
    c, B, p = draw.of([24, 35, 50]), draw(100, 600), draw(5, 15, 0.01)
    x, y = draw(2, 9, 0.01), draw(-9, -2, 0.01)
    X, Y, Z = model_point(x, y, p, B, c)
    return dict(c=c, B=B, p=p, x=x, y=y), Y, [X, -Y, Z]


def base(draw: Chance) -> Numbers:
    """Base from the overlap."""
    n, p, c = draw.of([2848, 4000, 4288, 6000]), draw(3, 8, 0.01), draw.of([24, 35, 50])
    H, overlap = draw(400, 2000, 10), draw(55, 85, 5)
    width = n * p / 1000 * H / c
    answer = width * (100 - overlap) / 100
    return (
        dict(n=n, p=p, c=c, H=H, o=overlap, w=width),
        answer,
        [width * overlap / 100, width, 1000 * answer],
    )


def rmse_heights(draw: Chance) -> Numbers:
    """RMSE of some heights."""
    e = draw.several(5, -4, 12)
    found = quality(e.astype(float), np.zeros(5))
    given = dict(e=listed(e), ee=int(e @ e), sum=total(e**2))
    return given, found.rmse, [found.rmse * np.sqrt(5 / 4), e.std(), found.mean]


def nmad_heights(draw: Chance) -> Numbers:
    """NMAD of some heights."""
    e = np.append(draw.several(6, -8, 9, 0.5), draw(40, 90))
    e = np.array(draw.order(list(e)))
    found = quality(e.astype(float), np.zeros(7)).nmad
    middle = np.median(e)
    off = np.abs(e - middle)
    given = dict(e=listed(e), m=middle, off=listed(np.sort(off)), mad=np.median(off))
    return given, found, [np.median(off), e.std(), 1.4826 * np.median(np.abs(e))]


def relief(draw: Chance) -> Numbers:
    """Relief displacement."""
    H, h, r = draw(500, 2000, 10), draw(8, 60), draw(400, 2500, 10)
    answer = r * h / H
    return (
        dict(H=H, h=h, r=r),
        answer,
        [r * h / (H - h), r * (1 - h / H), r * h / (H + h)],
    )


# --- 9: your camera, your two photos ---


def board_redundancy(draw: Chance) -> Numbers:
    """Redundancy with a free board."""
    m, n = draw(8, 30), draw(24, 90)
    u = 10 + 6 * m + 3 * n - 7
    slips = [2 * m * n - u - 7, 2 * m * n - 10 - 6 * m, 2 * m * n - u + n]
    return dict(m=m, n=n, u=u, obs=2 * m * n), 2 * m * n - u, slips


def base_of_scale(draw: Chance) -> Numbers:
    """Length of the base."""
    f, D, d = draw(2000, 4000, 10), draw(200, 900), draw(0.4, 3, 0.001)
    u = np.array([[d / 2, 0, -2], [-d / 2, 0, -2]])  # two points, seen from the left
    at = [[one[0] / -one[2] * f, 0.0] for one in u]
    other = [[(one[0] - 1) / -one[2] * f, 0.0] for one in u]
    exterior = np.array([1.0, 0, 0, 0, 0, 0])
    answer = base_length(exterior, np.array(at), np.array(other), f, D)
    return dict(D=D, d=d), answer, [1000 * d / D, D, D * d]


def wrong_distance(draw: Chance) -> Numbers:
    """A distance measured wrongly."""
    D, e, Z = draw(300, 1200), draw(0.5, 6, 0.1), draw(1500, 4000, 10)
    answer = Z * e / D
    return dict(D=D, e=e, Z=Z), answer, [e, e * D / Z, Z * (e / D) * 2]


def depth_sd(draw: Chance) -> Numbers:
    """Precision of a depth."""
    f, Z = draw(1000, 4000, 10), draw(0.8, 4, 0.1)
    B, s = draw(0.1, 0.6, 0.01), draw(0.05, 0.5, 0.05)
    answer = 1000 * Z**2 / (B * f) * s
    return (
        dict(f=f, Z=Z, B=B, s=s),
        answer,
        [1000 * Z / (B * f) * s, 1000 * Z / f * s, answer * np.sqrt(2)],
    )


def view(draw: Chance) -> Numbers:
    """Angle of view."""
    n, p, c = draw.of([4000, 4032, 4608, 8160]), draw(0.8, 2, 0.05), draw(2, 7, 0.01)
    w = n * p / 1000
    answer = 2 * np.degrees(np.arctan(w / 2 / c))
    return (
        dict(n=n, p=p, c=c, w=w),
        answer,
        [answer / 2, np.degrees(np.arctan(w / c)), np.radians(answer)],
    )


def square(draw: Chance) -> Numbers:
    """Squares of a board."""
    f, s, Z, t = draw(1000, 4000, 10), draw(15, 40), draw(400, 1500, 10), draw(20, 55)
    answer = f * s / Z * np.cos(np.radians(t))
    return (
        dict(f=f, s=s, Z=Z, t=t),
        answer,
        [f * s / Z, f * s / Z * np.sin(np.radians(t)), f * s / Z * abs(np.cos(t))],
    )


def focus(draw: Chance) -> Numbers:
    """Focus on something near."""
    f, Z = draw(15, 60, 0.1), draw(400, 2500, 10)
    answer = f * f / (Z - f)
    return dict(f=f, Z=Z), answer, [f * Z / (Z - f), f * Z / (Z + f), f / Z]
