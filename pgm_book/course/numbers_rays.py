"""Questions with numbers on rays and adjustments: lessons A1, 4, 5, 6, 8 and 9."""

import numpy as np

from pgm_book.course.numbers import Asked, Chance, listed, matrix, question, total
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


@question("A1", "Weighted mean", "m", 4)
def weighted_mean(draw: Chance) -> Asked:
    H = draw(95, 105, 0.1)
    heights = np.round(H + draw.several(3, -9, 9) / 1000, 3)
    km = draw.several(3, 0.4, 6, 0.2)
    x, *_ = adjust(np.ones((3, 1)), 1 / km, heights)
    return Asked(
        dict(
            h=listed(heights, "%.3f"),
            km=listed(km),
            p=listed(1 / km, "%.4f"),
            sum=np.sum(1 / km),
        ),
        "Three levelled routes give the height of a point as $%(h)s$ m. They are "
        "$%(km)s$ km long, and share no line. What is the adjusted height?",
        x[0],
        r"The weights are $p = 1/L = %(p)s$, their sum is %(sum).4f. $H = \sum p\,l / "
        r"\sum p = %(answer)s$ m.",
        {
            "short routes count more": float(np.average(heights, weights=km)),
            "the routes have different weights": heights.mean(),
            "the weight is 1/L, not its square": float(
                np.average(heights, weights=km**-2)
            ),
        },
    )


@question("A1", "How good is the mean?", "mm", 2)
def mean_sd(draw: Chance) -> Asked:
    s = draw.several(3, 1, 6, 0.1)
    answer = 1 / np.sqrt(np.sum(s**-2))
    return Asked(
        dict(s=listed(s), w=listed(s**-2, "%.4f"), sum=np.sum(s**-2)),
        "Three independent measurements of one length have the standard deviations "
        "$%(s)s$ mm. What is the standard deviation of their weighted mean?",
        answer,
        r"With $\sigma_0 = 1$ mm the weights are $1/\sigma_i^2 = %(w)s$, together "
        r"%(sum).4f. $1/\sqrt{%(sum).4f} = %(answer)s$ mm.",
        {
            "the best alone is not the mean": s.min(),
            "the plain mean is no weighted one": np.linalg.norm(s) / 3,
            "standard deviations are not averaged": s.mean(),
        },
    )


@question("A1", "Redundancy of a levelling net", "", 0)
def net_redundancy(draw: Chance) -> Asked:
    points, known = draw(6, 20), draw(1, 3)
    lines = points + draw(2, 20)
    return Asked(
        dict(points=points, known=known, lines=lines, u=points - known),
        "A levelling net joins %(points)d points by %(lines)d levelled lines; the "
        "heights of %(known)d of the points are known. What is its redundancy?",
        lines - points + known,
        r"$%(lines)d$ observations, $%(points)d - %(known)d = %(u)d$ unknown heights: "
        r"$r = %(lines)d - %(u)d = %(answer)s$.",
        {
            "known heights are no unknowns": lines - points,
            "every unknown height takes one": lines - known,
            "observations minus unknowns": lines - points - known,
        },
    )


@question("A1", "The sigma0 of an adjustment", "mm", 2)
def sigma0(draw: Chance) -> Asked:
    v, km, u = (
        draw.several(5, -6, 6, 0.1),
        draw.several(5, 0.5, 4, 0.5),
        draw.of([2, 3]),
    )
    pvv = np.sum(v**2 / km)
    answer = np.sqrt(pvv / (5 - u))
    return Asked(
        dict(v=listed(v), km=listed(km), u=u, pvv=pvv, r=5 - u),
        "Five levelled lines of $%(km)s$ km have the residuals $%(v)s$ mm; %(u)d heights "
        r"were unknown. How large is $\sigma_0$, the standard deviation of a line of "
        "1 km?",
        answer,
        r"With $p = 1/L$, $v^TPv = %(pvv).3f$ mm², and $r = 5 - %(u)d = %(r)d$. "
        r"$\sigma_0 = \sqrt{v^TPv / r} = \sqrt{%(pvv).3f / %(r)d} = %(answer)s$ mm.",
        {
            "divide by the redundancy, not by n": np.sqrt(pvv / 5),
            "the unknowns are more than one": np.sqrt(pvv / 4),
            "the lines have weights": np.linalg.norm(v) / np.sqrt(5 - u),
        },
    )


@question("A1", "Redundancy number", "", 3)
def redundancy_number(draw: Chance) -> Asked:
    km = draw.several(3, 0.5, 8, 0.5)
    p = 1 / km
    r = redundancy_numbers(np.ones((3, 1)), p)[0]
    return Asked(
        dict(km=listed(km), first=km[0], p=p[0], sum=p.sum()),
        "A height is determined by three independent levelled routes of $%(km)s$ km. "
        "What is the redundancy number of the first one, %(first)g km long?",
        r,
        r"$r_1 = 1 - (A\,Q\,A^TP)_{11} = 1 - p_1 / \sum p = 1 - %(p).4f / %(sum).4f = "
        "%(answer)s$.",
        {
            "this is what the unknown absorbs": 1 - r,
            "the weight is 1/L": 1 - km[0] / km.sum(),
            "only equal weights give equal shares": 2 / 3,
        },
    )


@question("A1", "Baarda's w", "", 2)
def baarda(draw: Chance) -> Asked:
    v, s, r = draw(3, 20, 0.1), draw(1, 4, 0.1), draw(0.15, 0.75, 0.01)
    w = v / s / np.sqrt(r)
    return Asked(
        dict(v=v, s=s, r=r),
        "A residual is %(v)g mm; its observation has a stated standard deviation of "
        "%(s)g mm and the redundancy number %(r)g. How large is Baarda's $w$?",
        w,
        r"$w = v / (\sigma \sqrt r) = %(v)g / (%(s)g \cdot \sqrt{%(r)g}) = %(answer)s$; "
        "the limit is 3.29.",
        {
            "a residual is smaller than the error behind it": v / s,
            "the redundancy number stands under a root": v / s / r,
            "divide by the root of r": w * r,
        },
    )


@question("A1", "A blunder and its residual", "mm", 1)
def blunder(draw: Chance) -> Asked:
    r, dv = draw(0.08, 0.75, 0.01), draw(2, 15, 0.1)
    return Asked(
        dict(r=r, dv=dv),
        "The redundancy number of an observation is %(r)g. Its residual is %(dv)g mm "
        "larger than it should be, because this one observation has a blunder. How "
        "large is the blunder, without its sign?",
        dv / r,
        r"$\Delta v = -r\,\Delta l$, so $|\Delta l| = %(dv)g / %(r)g = %(answer)s$ mm.",
        {
            "the residual shows a share of the blunder": dv * r,
            "the unknowns absorb 1 - r": dv / (1 - r),
            "r stands without a root": dv / np.sqrt(r),
        },
    )


@question("A1", "Error ellipse", "mm", 2)
def error_ellipse(draw: Chance) -> Asked:
    a, b = draw(6, 40, 0.5), draw(6, 40, 0.5)
    c = round(draw.of([-1, 1]) * draw(0.2, 0.85, 0.05) * np.sqrt(a * b), 1)
    long, short, _ = ellipse(np.array([[a, c], [c, b]]))
    root = np.hypot((a - b) / 2, c)
    return Asked(
        dict(C=matrix([[a, c], [c, b]]), a=a, b=b, c=c, mean=(a + b) / 2, root=root),
        "The covariance of a point is $%(C)s$ mm². How long is the larger semi-axis of "
        "its standard error ellipse?",
        long,
        r"The larger eigenvalue is $\frac{a + b}{2} + \sqrt{(\frac{a - b}{2})^2 + c^2} = "
        "%(mean)g + %(root).4f$ mm², and its root %(answer)s mm.",
        {
            "this is the smaller one": short,
            "a semi-axis is the root of an eigenvalue": long**2,
            "the covariance turns and stretches the ellipse": np.sqrt(max(a, b)),
        },
    )


# --- 4: rotation matrices ---


@question("4", "Rotate the frame", "mm", 3)
def plane_rotation(draw: Chance) -> Asked:
    X, Y, k = draw(5, 60, 0.1), draw(5, 60, 0.1), draw(8, 80) * draw.of([-1, 1])
    M = rotation.matrix(0, 0, np.radians(k))
    x, y, _ = M @ (X, Y, 0)
    return Asked(
        dict(X=X, Y=Y, k=k),
        r"A frame is rotated by $\kappa = %(k)d°$, counter-clockwise. A point had $X = "
        "%(X)g$ mm and $Y = %(Y)g$ mm in the old frame. What is its $x$ in the rotated "
        "frame?",
        x,
        r"$x = X \cos\kappa + Y \sin\kappa = %(X)g \cos(%(k)d°) + %(Y)g \sin(%(k)d°) = "
        "%(answer)s$ mm.",
        {
            "the frame rotates, not the point": (M.T @ (X, Y, 0))[0],
            "degrees are no radians": X * np.cos(k) + Y * np.sin(k),
            "this is y": y,
        },
    )


@question("4", "An element of M", "", 4)
def element(draw: Chance) -> Asked:
    o, f, k = draw.several(3, 8, 55)
    M = rotation.matrix(*np.radians([o, f, k]))
    reverse = np.linalg.multi_dot(
        [rotation.matrix(*np.radians(one)) for one in ((o, 0, 0), (0, f, 0), (0, 0, k))]
    )
    return Asked(
        dict(o=o, f=f, k=k),
        r"A photo has $\omega = %(o)d°$, $\varphi = %(f)d°$ and $\kappa = %(k)d°$. How "
        r"large is the element $m_{12}$ of $M = M_\kappa M_\varphi M_\omega$?",
        M[0, 1],
        r"$m_{12} = \sin\omega\sin\varphi\cos\kappa + \cos\omega\sin\kappa = "
        r"\sin %(o)d° \sin %(f)d° \cos %(k)d° + \cos %(o)d° \sin %(k)d° = %(answer)s$ "
        "(M 2.8).",
        {
            "the first index is the row": M[1, 0],
            "degrees are no radians": rotation.matrix(o, f, k)[0, 1],
            "the rotation made first stands on the right": reverse[0, 1],
        },
    )


@question("4", "Omega, in every quadrant", "°", 2)
def omega(draw: Chance) -> Asked:
    o = np.radians(draw(95, 170)) * draw.of([-1, 1])
    M = rotation.matrix(o, np.radians(draw(-30, 30)), np.radians(draw(-60, 60)))
    m32, m33 = np.round(M[2, 1:], 4)
    answer = np.degrees(np.arctan2(-m32, m33))
    return Asked(
        dict(m32=m32, m33=m33),
        r"A rotation matrix has $m_{32} = %(m32).4f$ and $m_{33} = %(m33).4f$, and "
        r"$\cos\varphi$ is positive. How large is $\omega$, between −180° and 180°?",
        answer,
        r"$\tan\omega = -m_{32}/m_{33}$ (M 2.10), with the quadrant from both signs: "
        r"$\sin\omega$ has the sign of $-m_{32}$, $\cos\omega$ that of $m_{33}$, which "
        r"is negative. $\omega = \operatorname{atan2}(%(m32).4f \cdot (-1),\ %(m33).4f) "
        "= %(answer)s°$.",
        {
            "arctan forgets the quadrant": np.degrees(np.arctan(-m32 / m33)),
            "the sign of m32 is reversed": -answer,
            "degrees are wanted": np.radians(answer),
        },
    )


@question("4", "Tilt of a photo", "°", 2)
def tilt(draw: Chance) -> Asked:
    o, f = draw(8, 40), draw(8, 40)
    M = rotation.matrix(*np.radians([o, f, 0]))
    answer = np.degrees(rotation.to_tilt_azimuth_swing(M)[0])
    return Asked(
        dict(o=o, f=f),
        r"A photo has $\omega = %(o)d°$ and $\varphi = %(f)d°$. How large is the angle "
        "between its viewing direction and the vertical?",
        answer,
        r"The viewing direction is minus the third row of $M$; its angle $t$ to the "
        r"vertical has $\cos t = m_{33} = \cos\omega\cos\varphi = \cos %(o)d° \cos "
        r"%(f)d°$, so $t = %(answer)s°$ (M 2.8).",
        {
            "only small angles add as squares": np.hypot(o, f),
            "the angles have different axes": o + f,
            "degrees are wanted": np.radians(answer),
        },
    )


@question("4", "Angle of a rotation", "°", 2)
def whole_angle(draw: Chance) -> Asked:
    M = rotation.matrix(*np.radians(draw.several(3, -50, 50)))
    diagonal = np.round(np.diag(M), 4)
    trace = diagonal.sum()
    answer = np.degrees(np.arccos((trace - 1) / 2))
    return Asked(
        dict(d=listed(diagonal, "%.4f"), trace=trace),
        "The diagonal of a rotation matrix is $%(d)s$. Through which angle does the "
        "matrix rotate, about one suitable axis?",
        answer,
        r"The trace is $1 + 2\cos\theta = %(trace).4f$, so $\theta = \arccos((%(trace).4f"
        " - 1)/2) = %(answer)s°$.",
        {
            "the trace of a rotation by 0 is 3": np.degrees(np.arccos(trace / 3)),
            "degrees are wanted": np.radians(answer),
            "the trace holds two cosines and a one": np.degrees(
                np.arccos(np.clip(trace - 2, -1, 1))
            ),
        },
    )


@question("4", "A small error of kappa", "px", 1)
def small_kappa(draw: Chance) -> Asked:
    k, x, p = draw(0.02, 0.5, 0.01), draw(4, 18, 0.1), draw(3, 9, 0.01)
    answer = x * np.radians(k) / p * 1000
    return Asked(
        dict(k=k, x=x, p=p),
        r"The $\kappa$ of a vertical photo is wrong by %(k)g°. By how many pixels of "
        "%(p)g µm is a point displaced that lies %(x)g mm from the principal point?",
        answer,
        r"For a small angle the displacement is the distance times the angle in "
        r"radians: $%(x)g\ \text{mm} \cdot %(k)g \cdot \pi/180 / (%(p)g\ \text{µm}) = "
        "%(answer)s$ px.",
        {
            "radians, not degrees": x * k / p * 1000,
            "a full turn has 2 pi": answer / 2,
            "gon are no degrees": answer * 0.9,
        },
    )


@question("4", "Nadir point", "mm", 2)
def nadir(draw: Chance) -> Asked:
    c, t = draw.of([18, 24, 35, 50, 153]), draw(4, 35, 0.5)
    down = rotation.matrix(np.radians(t), 0, 0) @ (0, 0, -1)
    answer = c * abs(down[1] / down[2])
    return Asked(
        dict(c=c, t=t),
        "A camera with $c = %(c)d$ mm is tilted by %(t)g° from the vertical. How far "
        "from the principal point lies the image of the nadir, the point vertically "
        "below the camera?",
        answer,
        r"The vertical makes the angle %(t)g° with the axis, so the distance is "
        r"$c \tan t = %(c)d \cdot \tan %(t)g° = %(answer)s$ mm.",
        {
            "the photo is a plane": c * np.sin(np.radians(t)),
            "the isocentre lies at half the angle": c * np.tan(np.radians(t / 2)),
            "an arc is no tangent": c * np.radians(t),
            "degrees are no radians": c * abs(np.tan(t)),
        },
    )


@question("4", "Angle in a quaternion", "°", 2)
def quaternion(draw: Chance) -> Asked:
    q = draw.several(4, -9, 9)
    q[0] = draw(3, 9)
    R = rotation.from_quaternion(q / np.linalg.norm(q))
    answer = np.degrees(rotation.angle_between(R, np.eye(3)))
    return Asked(
        dict(q=listed(q), w=q[0], n2=int(q @ q)),
        "A rotation is given as the quaternion $(w, x, y, z)$, proportional to $(%(q)s)"
        "$. Through which angle does it rotate?",
        answer,
        r"Normalized, $w = %(w)d / \sqrt{%(n2)d} = \cos(\theta/2)$, so $\theta = 2 "
        r"\arccos(%(w)d / \sqrt{%(n2)d}) = %(answer)s°$.",
        {
            "w is the cosine of half the angle": answer / 2,
            "degrees are wanted": np.radians(answer),
            "the length is the root of the sum": 2
            * np.degrees(np.arccos(min(q[0] / np.abs(q).sum(), 1))),
        },
    )


# --- 5: intersection ---


@question("5", "A photo coordinate", "mm", 3)
def collinearity(draw: Chance) -> Asked:
    c, H = draw.of([24, 35, 153]), draw(600, 1500, 10)
    k, X, Y = draw(15, 75), draw(80, 300), draw(80, 300)
    exterior = np.array([0, 0, H, 0, 0, np.radians(k)])
    x, y = project(exterior, np.array([[X, Y, 0]]), c)[0]
    other = project(exterior * [1, 1, 1, 1, 1, -1], np.array([[X, Y, 0]]), c)[0, 0]
    return Asked(
        dict(c=c, H=H, k=k, X=X, Y=Y, U=x * H / c),
        r"A vertical photo ($\omega = \varphi = 0$, $\kappa = %(k)d°$, $c = %(c)d$ mm) "
        "is taken from %(H)d m above the ground. A ground point lies %(X)d m east (X) "
        "and %(Y)d m north (Y) of the nadir. What is its photo coordinate $x$?",
        x,
        r"$U = X\cos\kappa + Y\sin\kappa = %(U).3f$ m and $W = -%(H)d$ m, so $x = "
        r"-c\,U/W = %(c)d \cdot %(U).3f / %(H)d = %(answer)s$ mm (M 2.20).",
        {
            "M leads from the ground to the photo": other,
            "W is negative, below the camera": -x,
            "this is y": y,
        },
    )


@question("5", "Two rays in a plane", "m", 2)
def two_rays(draw: Chance) -> Asked:
    B, t1, t2 = draw(50, 400), draw(0.1, 0.7, 0.01), draw(-0.6, 0.05, 0.01)
    rays = np.array([[t1, 0, -1], [t2, 0, -1]])
    X, _, Z = intersection(np.array([[0, 0, 0], [B, 0, 0]]), rays)
    return Asked(
        dict(B=B, t1=t1, t2=t2),
        "Two stations stand at $X = 0$ and at $X = %(B)d$ m, at the same height. Their "
        "rays to a point have the directions $(%(t1)g,\\ 0,\\ -1)$ and $(%(t2)g,\\ 0,\\ "
        "-1)$. What is the $X$ of the point?",
        X,
        r"At the depth $D$ the rays are at $%(t1)g\,D$ and $%(B)d + (%(t2)g)\,D$. They "
        r"meet where $D = %(B)d / (%(t1)g - (%(t2)g))$, and $X = %(t1)g\,D = %(answer)s$ "
        "m.",
        {
            "this is the depth": -Z,
            "the second ray begins at the second station": X - B,
            "directions are subtracted, with their signs": t1 * B / (t1 + t2 or 9),
        },
    )


@question("5", "Are the rays coplanar?", "", 2)
def coplanar(draw: Chance) -> Asked:
    b = np.array([draw(2, 9), draw(-2, 2), draw(-2, 2)])
    u1 = np.array([draw(0.1, 0.9, 0.1), draw(-0.9, 0.9, 0.1), -1])
    u2 = np.array([draw(-0.9, 0.1, 0.1), draw(-0.9, 0.9, 0.1), -1])
    F = coplanarity.condition(b, np.eye(3), u1[None], u2[None])[0]
    return Asked(
        dict(b=listed(b), u1=listed(u1), u2=listed(u2), n=listed(np.cross(u1, u2))),
        "The base of two photos is $b = (%(b)s)$ m, the rays of a point are $u' = "
        "(%(u1)s)$ and $u'' = (%(u2)s)$, all in one frame. How large is the determinant "
        r"$F = b \cdot (u' \times u'')$?",
        F,
        r"$u' \times u'' = (%(n)s)$, and its product with $b$ is $F = %(answer)s$ "
        "(M 2.30). The rays would meet where it is zero.",
        {
            "the left ray comes first": -F,
            "a cross product has differences": float(
                b
                @ (
                    np.roll(u1, -1) * np.roll(u2, -2)
                    + np.roll(u1, -2) * np.roll(u2, -1)
                )
            ),
            "all three parts of the base count": float(b[0] * np.cross(u1, u2)[0]),
        },
    )


@question("5", "Redundancy of an intersection", "", 0)
def intersection_redundancy(draw: Chance) -> Asked:
    photos, points = draw(2, 7), draw(3, 40)
    return Asked(
        dict(photos=photos, points=points, n=2 * photos * points, u=3 * points),
        "The orientation of %(photos)d photos is known. %(points)d points are measured "
        "in all of them and intersected together. What is the redundancy?",
        points * (2 * photos - 3),
        r"Each point has 2 coordinates in each photo and 3 unknowns: $%(n)d - %(u)d = "
        "%(answer)s$.",
        {
            "a photo gives two coordinates": points * (photos - 3),
            "a point has three unknowns": points * (2 * photos - 2),
            "known photos are no unknowns": points * (2 * photos - 3) - 6 * photos,
        },
    )


@question("5", "Redundancy of a relative orientation", "", 0)
def relative_redundancy(draw: Chance) -> Asked:
    n, wrong = draw(9, 90), draw(1, 3)
    return Asked(
        dict(n=n, wrong=wrong, left=n - wrong),
        "%(n)d points are matched in two photos, whose cameras are known; %(wrong)d of "
        "the matches are rejected. Nothing is known on the ground. What is the "
        "redundancy of the relative orientation?",
        n - wrong - 5,
        r"Each of the %(left)d pairs of rays gives one condition of coplanarity; five "
        r"numbers of the right photo are unknown: $%(left)d - 5 = %(answer)s$.",
        {
            "the scale stays open": n - wrong - 6,
            "rejected points do not count": n - 5,
            "a pair of rays gives one condition": 2 * (n - wrong) - 5,
        },
    )


@question("5", "How good is the height?", "cm", 1)
def height_sd(draw: Chance) -> Asked:
    c, H, s = draw.of([24, 35, 100, 153]), draw(300, 2000, 10), draw(1, 8, 0.5)
    B = draw(round(0.25 * H / 10) * 10, round(0.7 * H / 10) * 10, 10)
    answer = H / B * H / c * np.sqrt(2) * s / 10
    return Asked(
        dict(c=c, H=H, s=s, B=B),
        "Two vertical photos are taken from %(H)d m, %(B)d m apart, with $c = %(c)d$ mm. "
        "Image coordinates are good to %(s)g µm (standard deviation). What is the "
        "standard deviation of an intersected height, midway between the stations?",
        answer,
        r"$\sigma_Z = \frac{H}{B}\,\frac{H}{c}\,\sqrt2\,\sigma = \frac{%(H)d}{%(B)d} "
        r"\cdot \frac{%(H)d}{%(c)d} \cdot \sqrt2 \cdot %(s)g$ µm, that is %(answer)s cm.",
        {
            "the parallax is a difference of two coordinates": answer / np.sqrt(2),
            "this is the planimetry": H / c / np.sqrt(2) * s / 10,
            "the rays meet at a flat angle: H/B": H / c * np.sqrt(2) * s / 10,
        },
    )


@question("5", "Scale of a model", "", 3)
def model_scale(draw: Chance) -> Asked:
    a, b = draw.several(3, -9, -1, 0.1), draw.several(3, 1, 9, 0.1)
    D = draw(30, 200, 0.1)
    d = np.linalg.norm(b - a)
    return Asked(
        dict(a=listed(a), b=listed(b), D=D, d=d),
        "In a model from relative orientation two points have the coordinates $(%(a)s)$ "
        "and $(%(b)s)$. On the ground they are %(D)g m apart. By which scale is the "
        "model multiplied?",
        D / d,
        r"In the model the distance is %(d).5f, so $s = %(D)g / %(d).5f = %(answer)s$.",
        {
            "the scale leads from the model to the ground": d / D,
            "all three differences count": D / np.linalg.norm((b - a)[:2]),
            "lengths add as squares": D / np.abs(b - a).sum(),
        },
    )


@question("5", "From the model to the ground", "m", 2)
def to_ground(draw: Chance) -> Asked:
    s, k = draw(2, 30, 0.1), draw(15, 80)
    x, y, T = draw(2, 9, 0.1), draw(2, 9, 0.1), draw(1000, 5000)
    R = rotation.matrix(0, 0, np.radians(k)).T
    answer = s * (R @ (x, y, 0))[0] + T
    return Asked(
        dict(s=s, k=k, x=x, y=y, T=T),
        "Absolute orientation gave the scale $s = %(s)g$, a rotation of the **model** by "
        "%(k)d° about Z, counter-clockwise, and the translation $T_X = %(T)d$ m. Which "
        "$X$ on the ground has the model point $x = %(x)g$, $y = %(y)g$?",
        answer,
        r"$X = s\,(x\cos\alpha - y\sin\alpha) + T_X = %(s)g\,(%(x)g \cos %(k)d° - %(y)g "
        r"\sin %(k)d°) + %(T)d = %(answer)s$ m.",
        {
            "the points rotate, not the frame": s * (R.T @ (x, y, 0))[0] + T,
            "the translation is not scaled": s * ((R @ (x, y, 0))[0] + T),
            "the model has a scale": (R @ (x, y, 0))[0] + T,
        },
    )


# --- 6: self-calibrating bundle adjustment ---


@question("6", "Redundancy of a bundle", "", 0)
def bundle_redundancy(draw: Chance) -> Asked:
    m, n, lost = draw(5, 20), draw(20, 90), draw(0, 40)
    rays = m * n - lost
    u = 10 + 6 * m + 3 * n
    return Asked(
        dict(m=m, n=n, rays=rays, u=u),
        "A camera with 10 unknown parameters takes %(m)d photos of %(n)d targets; "
        "%(rays)d rays are measured. No coordinate on the ground is known, and the "
        "seven motions are held by inner constraints. What is the redundancy?",
        2 * rays - u + 7,
        r"$2 \cdot %(rays)d$ observations and 7 constraints, $10 + 6 \cdot %(m)d + 3 "
        r"\cdot %(n)d = %(u)d$ unknowns: $r = %(answer)s$.",
        {
            "the datum gives seven back": 2 * rays - u,
            "a ray gives two observations": rays - u + 7,
            "the camera is unknown too": 2 * rays - u + 17,
        },
    )


@question("6", "Zeros of the normal matrix", "%", 1)
def zeros(draw: Chance) -> Asked:
    m, n, p = draw(4, 20), draw(15, 90), draw(3, 10)
    size = p + 6 * m + 3 * n
    empty = 36 * m * (m - 1) + 9 * n * (n - 1)
    answer = 100 * empty / size**2
    return Asked(
        dict(m=m, n=n, p=p, size=size, a=36 * m * (m - 1), b=9 * n * (n - 1)),
        "A bundle adjustment has one camera with %(p)d parameters, %(m)d photos and "
        "%(n)d targets, and every photo shows every target. What percentage of its "
        "normal matrix is zero?",
        answer,
        r"It has %(size)d rows. Two photos never share a ray: $36 \cdot %(m)d \cdot "
        r"(%(m)d - 1) = %(a)d$ zeros. Nor do two targets: $9 \cdot %(n)d \cdot (%(n)d - "
        r"1) = %(b)d$. Together $(%(a)d + %(b)d) / %(size)d^2$, that is %(answer)s %%.",
        {
            "photos do not share rays either": 900 * n * (n - 1) / size**2,
            "this is what is not zero": 100 - answer,
            "the diagonal blocks are full": 100 * (36 * m * m + 9 * n * n) / size**2,
        },
    )


@question("6", "Radial distortion", "µm", 1)
def radial(draw: Chance) -> Asked:
    x, y = draw(3, 10, 0.1), draw(3, 8, 0.1)
    K1, K2 = draw(-9, -3, 0.1), draw(2, 6, 0.1)
    camera = [35, 0, 0, K1 * 1e-5, K2 * 1e-8, 0, 0, 0, 0, 0]
    dx, dy = 1000 * (lens.without_lens(np.array([[x, y]]), camera)[0] - (x, y))
    rho2 = x * x + y * y
    return Asked(
        dict(x=x, y=y, K1=K1, K2=K2, rho2=rho2, f=dx / 1000 / x),
        "An image point lies at $x = %(x)g$ mm, $y = %(y)g$ mm from the principal point. "
        r"The lens has $K_1 = %(K1)g \cdot 10^{-5}$ mm⁻² and $K_2 = %(K2)g \cdot "
        "10^{-8}$ mm⁻⁴. How large is the correction $dx$?",
        dx,
        r"$\rho^2 = %(rho2).4f$ mm², and $dx = x\,(K_1\rho^2 + K_2\rho^4) = %(x)g \cdot "
        r"(%(f).4e)\ \text{mm} = %(answer)s$ µm (M 2.89).",
        {
            "this is dy": dy,
            "the correction along the radius is longer than dx": np.hypot(dx, dy),
            "the power is even inside the bracket": 1e3
            * x
            * (K1 * 1e-5 * rho2**0.5 + K2 * 1e-8 * rho2),
            "the correction has the sign of K1": -dx,
        },
    )


@question("6", "Decentring distortion", "µm", 2)
def decentring(draw: Chance) -> Asked:
    x, y = draw(3, 11, 0.1), draw(-8, -3, 0.1)
    P1, P2 = draw(2, 9, 0.1), draw(2, 9, 0.1)
    camera = [35, 0, 0, 0, 0, 0, P1 * 1e-5, P2 * 1e-5, 0, 0]
    dx, dy = 1000 * (lens.without_lens(np.array([[x, y]]), camera)[0] - (x, y))
    rho2 = x * x + y * y
    return Asked(
        dict(x=x, y=y, P1=P1, P2=P2, rho2=rho2),
        "An image point lies at $x = %(x)g$ mm, $y = %(y)g$ mm from the principal point. "
        r"The lens has $P_1 = %(P1)g \cdot 10^{-5}$ mm⁻¹ and $P_2 = %(P2)g \cdot "
        "10^{-5}$ mm⁻¹, and no radial distortion. How large is the correction $dx$?",
        dx,
        r"$\rho^2 = %(rho2).4f$ mm², and $dx = P_1(\rho^2 + 2x^2) + 2 P_2\,xy = %(answer)s"
        "$ µm (M 2.89).",
        {
            "this is dy": dy,
            "the radius counts too": 1e-2 * (P1 * 2 * x * x + 2 * P2 * x * y),
            "the mixed term has a factor two": 1e-2
            * (P1 * (rho2 + 2 * x * x) + P2 * x * y),
            "the mixed term has the signs of x and y": 1e-2
            * (P1 * (rho2 + 2 * x * x) - 2 * P2 * x * y),
        },
    )


@question("6", "A sum of correlated terms", "µm", 2)
def correlated(draw: Chance) -> Asked:
    a, b, r = draw(3, 9, 0.1), draw(3, 9, 0.1), -draw(0.8, 0.98, 0.01)
    C = np.array([[a * a, r * a * b], [r * a * b, b * b]])
    answer = np.sqrt(C.sum())
    return Asked(
        dict(a=a, b=b, r=r),
        r"At the edge of a photo $K_1\rho^3$ has a standard deviation of %(a)g µm and "
        r"$K_2\rho^5$ one of %(b)g µm; their correlation is $%(r)g$. What is the "
        "standard deviation of their sum?",
        answer,
        r"$\sigma^2 = a^2 + b^2 + 2 r a b = %(a)g^2 + %(b)g^2 + 2 \cdot (%(r)g) \cdot "
        r"%(a)g \cdot %(b)g$, and its root %(answer)s µm.",
        {
            "the terms are correlated": np.hypot(a, b),
            "the covariance counts twice": np.sqrt(a * a + b * b + r * a * b),
            "the correlation is negative": np.sqrt(a * a + b * b - 2 * r * a * b),
        },
    )


@question("6", "Two halves of a calibration", "", 2)
def two_halves(draw: Chance) -> Asked:
    s1, s2 = draw(15, 60), draw(15, 60)
    c1 = draw(34.8, 35.2, 0.001)
    c2 = round(c1 + draw(0.06, 0.2, 0.001), 3)
    answer = (c2 - c1) * 1000 / np.hypot(s1, s2)
    return Asked(
        dict(s1=s1, s2=s2, c1=c1, c2=c2, d=(c2 - c1) * 1000, s=np.hypot(s1, s2)),
        "A camera is calibrated from two halves of its photos, independently: $c = "
        r"%(c1).3f$ mm ± %(s1)d µm and $c = %(c2).3f$ mm ± %(s2)d µm (standard "
        "deviations). How many standard deviations of the difference lie between them?",
        answer,
        r"The difference is %(d).0f µm, its standard deviation $\sqrt{%(s1)d^2 + "
        r"%(s2)d^2} = %(s).3f$ µm: %(answer)s of them.",
        {
            "standard deviations are not added": (c2 - c1) * 1000 / (s1 + s2),
            "both values are uncertain": (c2 - c1) * 1000 / s1,
            "the difference is less certain than their mean": 2 * answer,
        },
    )


@question("6", "What elimination saves", "", 1)
def elimination(draw: Chance) -> Asked:
    m, n = draw(9, 30), draw(30, 120)
    small, whole = 10 + 6 * m, 10 + 6 * m + 3 * n
    answer = (whole / small) ** 3
    return Asked(
        dict(m=m, n=n, small=small, whole=whole),
        "A bundle adjustment of one camera (10 parameters), %(m)d photos and %(n)d "
        "points eliminates the points first. The time to solve normal equations grows "
        "with the third power of their size. How many times quicker are the reduced "
        "ones solved than the whole ones?",
        answer,
        r"Reduced, they have $10 + 6 \cdot %(m)d = %(small)d$ rows, whole %(whole)d: "
        r"$(%(whole)d / %(small)d)^3 = %(answer)s$ times.",
        {
            "the time grows with the third power": whole / small,
            "the camera stays": (whole / (6 * m)) ** 3,
            "this is the memory": (whole / small) ** 2,
        },
    )


@question("6", "Precision after the adjustment", "µm", 3)
def after(draw: Chance) -> Asked:
    rays, m, n = draw(200, 900, 10), draw(5, 15), draw(20, 60)
    vv, s = draw(20, 400, 0.5), draw(0.5, 3, 0.1)
    r = 2 * rays - 10 - 6 * m - 3 * n + 7
    answer = np.sqrt(vv / r)
    return Asked(
        dict(rays=rays, m=m, n=n, vv=vv, s=s, r=r, pvv=vv / s**2),
        "A free network of %(m)d photos, %(n)d targets and one camera with 10 parameters "
        "has %(rays)d rays. A precision of %(s)g µm was stated for all image "
        "coordinates; the squares of the residuals add up to %(vv)g µm². Which precision "
        "of an image coordinate do the residuals show?",
        answer,
        r"$r = 2 \cdot %(rays)d - 10 - 6 \cdot %(m)d - 3 \cdot %(n)d + 7 = %(r)d$. "
        r"Whatever was stated, $\sigma_0\,\sigma = \sqrt{v^Tv / r} = \sqrt{%(vv)g / "
        "%(r)d} = %(answer)s$ µm.",
        {
            "this is sigma0, without a unit": answer / s,
            "the unknowns are subtracted": np.sqrt(vv / (2 * rays)),
            "this is a variance": vv / r,
        },
    )


# --- 8: stereo plotting ---


@question("8", "Depth from parallax", "m", 1)
def depth(draw: Chance) -> Asked:
    c, B, p = draw.of([24, 35]), draw(150, 600), draw(6, 14, 0.01)
    x1 = draw(2, 9, 0.01)
    x2 = round(x1 - p, 2)
    Z = model_point(x1, 0, x1 - x2, B, c)[2]
    return Asked(
        dict(c=c, B=B, x1=x1, x2=x2, p=x1 - x2),
        "In the normal case with $B = %(B)d$ m and $c = %(c)d$ mm a point lies at $x' = "
        "%(x1)g$ mm in the left and at $x'' = %(x2)g$ mm in the right photo. How far "
        "below the cameras is it?",
        -Z,
        r"$p_x = x' - x'' = %(p).2f$ mm, and $H = c\,B/p_x = %(c)d \cdot %(B)d / %(p).2f "
        "= %(answer)s$ m.",
        {
            "the parallax is a difference, with signs": c * B / abs(x1 + x2 or 9),
            "H grows with c": B * (x1 - x2) / c,
            "both coordinates make the parallax": c * B / x1,
        },
    )


@question("8", "Height of a mast", "m", 1)
def mast(draw: Chance) -> Asked:
    c, B = draw.of([24, 35, 50]), draw(200, 500)
    foot = draw(8, 12, 0.01)
    top = round(foot + draw(0.08, 0.6, 0.01), 2)
    Hf, Ht = c * B / foot, -model_point(0, 0, top, B, c)[2]
    return Asked(
        dict(c=c, B=B, foot=foot, top=top, Hf=Hf, Ht=Ht),
        "In the normal case with $B = %(B)d$ m and $c = %(c)d$ mm the foot of a mast has "
        "an x parallax of %(foot)g mm, its top one of %(top)g mm. How high is the mast?",
        Hf - Ht,
        r"The foot lies $c\,B/p_x = %(Hf).3f$ m below the cameras, the top %(Ht).3f m: "
        "the mast is %(answer)s m high.",
        {
            "a parallax is no height": c * B / (top - foot),
            "the differential formula holds for small differences": Hf
            / foot
            * (top - foot),
            "this is the depth of the top": Ht,
        },
    )


@question("8", "Precision of a height", "m", 3)
def sigma_z(draw: Chance) -> Asked:
    H, gsd, s = draw(400, 2000, 10), draw(0.05, 0.4, 0.005), draw(0.05, 0.8, 0.05)
    B = draw(round(0.025 * H) * 10, round(0.07 * H) * 10, 10)
    answer = sigma_height(H, B, gsd, s)
    return Asked(
        dict(H=H, B=B, gsd=gsd, s=s),
        "Two photos are taken from %(H)d m with a base of %(B)d m; the GSD is %(gsd)g m. "
        "Matching gives the parallax to %(s)g px (standard deviation). What is the "
        "standard deviation of the height?",
        answer,
        r"$\sigma_Z = \frac{H}{B}\,\mathrm{GSD}\;\sigma_{px} = \frac{%(H)d}{%(B)d} \cdot "
        r"%(gsd)g \cdot %(s)g = %(answer)s$ m.",
        {
            "H/B, not B/H": B / H * gsd * s,
            "the rays meet at a flat angle": gsd * s,
            "the parallax is one measurement here": answer * np.sqrt(2),
        },
    )


@question("8", "Where the point lies", "m", 1)
def along_base(draw: Chance) -> Asked:
    c, B, p = draw.of([24, 35, 50]), draw(100, 600), draw(5, 15, 0.01)
    x, y = draw(2, 9, 0.01), draw(-9, -2, 0.01)
    X, Y, Z = model_point(x, y, p, B, c)
    return Asked(
        dict(c=c, B=B, p=p, x=x, y=y),
        "In the normal case with $B = %(B)d$ m and $c = %(c)d$ mm a point lies at $x' = "
        "%(x)g$ mm, $y' = %(y)g$ mm in the left photo, and its x parallax is %(p)g mm. "
        "How far from the left station does it lie **across** the base, with its sign?",
        Y,
        r"$Y = B\,y'/p_x = %(B)d \cdot (%(y)g) / %(p)g = %(answer)s$ m.",
        {
            "this is along the base": X,
            "y keeps its sign": -Y,
            "this is the depth": Z,
        },
    )


@question("8", "Base from the overlap", "m", 1)
def base(draw: Chance) -> Asked:
    n, p, c = draw.of([2848, 4000, 4288, 6000]), draw(3, 8, 0.01), draw.of([24, 35, 50])
    H, overlap = draw(400, 2000, 10), draw(55, 85, 5)
    width = n * p / 1000 * H / c
    answer = width * (100 - overlap) / 100
    return Asked(
        dict(n=n, p=p, c=c, H=H, o=overlap, w=width),
        "A camera with $c = %(c)d$ mm and %(n)d pixels of %(p)g µm along the flight "
        "looks down from %(H)d m. Photos shall overlap by %(o)d %%. How far apart are "
        "they taken?",
        answer,
        r"A photo covers $%(n)d \cdot %(p)g\ \text{µm} \cdot %(H)d / %(c)d = %(w).3f$ m "
        r"of ground; what does not overlap, $1 - %(o)d/100$ of it, is the base: "
        "%(answer)s m.",
        {
            "this is what overlaps": width * overlap / 100,
            "the base is what does not overlap": width,
            "pixels have the size of the sensor": answer * 1000 / p,
        },
    )


@question("8", "RMSE of some heights", "cm", 2)
def rmse_heights(draw: Chance) -> Asked:
    e = draw.several(5, -4, 12)
    found = quality(e.astype(float), np.zeros(5))
    return Asked(
        dict(e=listed(e), ee=int(e @ e), sum=total(e**2)),
        "Five measured heights are off by $%(e)s$ cm. How large is their RMSE?",
        found.rmse,
        r"$\sqrt{\sum e^2 / n} = \sqrt{(%(sum)s)/5} = \sqrt{%(ee)d/5} = %(answer)s$ cm.",
        {
            "n counts, not n - 1": found.rmse * np.sqrt(5 / 4),
            "the mean is part of the RMSE": e.std(),
            "this is the mean": found.mean,
        },
    )


@question("8", "NMAD of some heights", "cm", 2)
def nmad_heights(draw: Chance) -> Asked:
    e = np.append(draw.several(6, -8, 9, 0.5), draw(40, 90))
    e = np.array(draw.order(list(e)))
    found = quality(e.astype(float), np.zeros(7)).nmad
    middle = np.median(e)
    off = np.abs(e - middle)
    return Asked(
        dict(e=listed(e), m=middle, off=listed(np.sort(off)), mad=np.median(off)),
        "Seven measured heights are off by $%(e)s$ cm. How large is their NMAD, 1.4826 "
        "times the median of the absolute deviations from the median?",
        found,
        r"The median is %(m)g cm. The deviations from it are, in order, $%(off)s$ cm; "
        r"their median is %(mad)g, and $1.4826 \cdot %(mad)g = %(answer)s$ cm.",
        {
            "the factor makes it a standard deviation": np.median(off),
            "the blunder hardly counts": e.std(),
            "deviations count from the median": 1.4826 * np.median(np.abs(e)),
        },
    )


@question("8", "Relief displacement", "px", 1)
def relief(draw: Chance) -> Asked:
    H, h, r = draw(500, 2000, 10), draw(8, 60), draw(400, 2500, 10)
    answer = r * h / H
    return Asked(
        dict(H=H, h=h, r=r),
        "A vertical photo is taken from %(H)d m above the ground. The top of a tower "
        "lies %(r)d px from the principal point; the tower is %(h)d m high and stands "
        "on the ground. How many pixels lie between its top and its foot?",
        answer,
        r"The top is imaged at $r = cR/(H - h)$, the foot at $cR/H$; the difference is "
        r"$r\,h/H = %(r)d \cdot %(h)d / %(H)d = %(answer)s$ px.",
        {
            "r belongs to the top": r * h / (H - h),
            "the foot lies nearer to the centre": r * (1 - h / H),
            "heights are not added": r * h / (H + h),
        },
    )


# --- 9: your camera, your two photos ---


@question("9", "Redundancy with a free board", "", 0)
def board_redundancy(draw: Chance) -> Asked:
    m, n = draw(8, 30), draw(24, 90)
    u = 10 + 6 * m + 3 * n - 7
    return Asked(
        dict(m=m, n=n, u=u, obs=2 * m * n),
        "A board of %(n)d corners is photographed %(m)d times; every photo shows all "
        "corners. The camera has 10 parameters, and the corners are unknown as well: "
        "the board may be bent. What is the redundancy?",
        2 * m * n - u,
        r"$2 \cdot %(m)d \cdot %(n)d = %(obs)d$ observations; $10 + 6 \cdot %(m)d + 3 "
        r"\cdot %(n)d - 7 = %(u)d$ unknowns, as shift, rotation and scale are open: "
        "%(answer)s.",
        {
            "seven motions show in no photo": 2 * m * n - u - 7,
            "this is the flat board": 2 * m * n - 10 - 6 * m,
            "a corner has three coordinates": 2 * m * n - u + n,
        },
    )


@question("9", "Length of the base", "mm", 1)
def base_of_scale(draw: Chance) -> Asked:
    f, D, d = draw(2000, 4000, 10), draw(200, 900), draw(0.4, 3, 0.001)
    u = np.array([[d / 2, 0, -2], [-d / 2, 0, -2]])  # two points, seen from the left
    at = [[one[0] / -one[2] * f, 0.0] for one in u]
    other = [[(one[0] - 1) / -one[2] * f, 0.0] for one in u]
    exterior = np.array([1.0, 0, 0, 0, 0, 0])
    answer = base_length(exterior, np.array(at), np.array(other), f, D)
    return Asked(
        dict(D=D, d=d),
        "Two photos were oriented relatively with a base of length 1. In this model two "
        "points are %(d).3f apart; a ruler gives %(D)d mm for the same distance. How "
        "long was the base?",
        answer,
        r"The model is multiplied by $%(D)d\ \text{mm} / %(d).3f$, and so is the base: "
        "%(answer)s mm.",
        {
            "the scale leads from the model to the ruler": 1000 * d / D,
            "the base has the length 1": D,
            "a distance is multiplied, not divided": D * d,
        },
    )


@question("9", "A distance measured wrongly", "mm", 2)
def wrong_distance(draw: Chance) -> Asked:
    D, e, Z = draw(300, 1200), draw(0.5, 6, 0.1), draw(1500, 4000, 10)
    answer = Z * e / D
    return Asked(
        dict(D=D, e=e, Z=Z),
        "The scale of two photos rests on one distance, %(D)d mm, and this was measured "
        "%(e)g mm too long. By how much is a depth of %(Z)d mm too large?",
        answer,
        r"All lengths grow by the same share, $%(e)g / %(D)d$: $%(Z)d \cdot %(e)g / "
        "%(D)d = %(answer)s$ mm.",
        {
            "the share counts, not the millimetres": e,
            "the share is e/D, not D/Z": e * D / Z,
            "a depth is a length, not a square": Z * (e / D) * 2,
        },
    )


@question("9", "How good is a depth?", "mm", 2)
def depth_sd(draw: Chance) -> Asked:
    f, Z = draw(1000, 4000, 10), draw(0.8, 4, 0.1)
    B, s = draw(0.1, 0.6, 0.01), draw(0.05, 0.5, 0.05)
    answer = 1000 * Z**2 / (B * f) * s
    return Asked(
        dict(f=f, Z=Z, B=B, s=s),
        "A telephone has a principal distance of %(f)d px. Two photos are taken %(B)g m "
        "apart, side by side, and matching gives the parallax to %(s)g px (standard "
        "deviation). What is the standard deviation of a depth of %(Z)g m?",
        answer,
        r"From $Z = c\,B/p$ follows $\sigma_Z = \frac{Z^2}{c\,B}\,\sigma_p = "
        r"\frac{%(Z)g^2}{%(f)d \cdot %(B)g} \cdot %(s)g$ m $= %(answer)s$ mm.",
        {
            "the depth counts twice": 1000 * Z / (B * f) * s,
            "a short base is a bad one": 1000 * Z / f * s,
            "the parallax is one measurement here": answer * np.sqrt(2),
        },
    )


@question("9", "Angle of view", "°", 1)
def view(draw: Chance) -> Asked:
    n, p, c = draw.of([4000, 4032, 4608, 8160]), draw(0.8, 2, 0.05), draw(2, 7, 0.01)
    w = n * p / 1000
    answer = 2 * np.degrees(np.arctan(w / 2 / c))
    return Asked(
        dict(n=n, p=p, c=c, w=w),
        "A telephone's camera has %(n)d pixels of %(p)g µm along its longer side and $c "
        "= %(c)g$ mm. Over which angle does it see along this side?",
        answer,
        r"The side is %(w).4f mm long, and the angle $2 \arctan(%(w).4f / (2 \cdot "
        "%(c)g)) = %(answer)s°$.",
        {
            "this is half the angle": answer / 2,
            "half the side belongs to half the angle": np.degrees(np.arctan(w / c)),
            "degrees are wanted": np.radians(answer),
        },
    )


@question("9", "Squares of a board", "px", 1)
def square(draw: Chance) -> Asked:
    f, s, Z, t = draw(1000, 4000, 10), draw(15, 40), draw(400, 1500, 10), draw(20, 55)
    answer = f * s / Z * np.cos(np.radians(t))
    return Asked(
        dict(f=f, s=s, Z=Z, t=t),
        "A board with squares of %(s)d mm is photographed from %(Z)d mm, with a "
        "principal distance of %(f)d px, and tilted by %(t)d° about its vertical axis. "
        "About how wide is a square in the photo, across the axis? Take the distance as "
        "equal over the square.",
        answer,
        r"Seen straight from the front it would be $%(f)d \cdot %(s)d / %(Z)d$ px wide; "
        r"the tilt shortens it by $\cos %(t)d°$: %(answer)s px.",
        {
            "the tilt shortens it": f * s / Z,
            "the cosine, not the sine": f * s / Z * np.sin(np.radians(t)),
            "degrees are no radians": f * s / Z * abs(np.cos(t)),
        },
    )


@question("9", "Focus on something near", "mm", 3)
def focus(draw: Chance) -> Asked:
    f, Z = draw(15, 60, 0.1), draw(400, 2500, 10)
    answer = f * f / (Z - f)
    return Asked(
        dict(f=f, Z=Z),
        "A lens with a focal length of %(f)g mm was calibrated for very distant objects. "
        "Now it is focused on an object %(Z)d mm in front of it. By how much does its "
        "principal distance grow (thin lens, $1/f = 1/Z + 1/c$)?",
        answer,
        r"$c = f\,Z/(Z - f)$, and $c - f = f^2/(Z - f) = %(f)g^2 / (%(Z)d - %(f)g) = "
        "%(answer)s$ mm.",
        {
            "this is the new principal distance": f * Z / (Z - f),
            "reciprocals are subtracted": f * Z / (Z + f),
            "the focal length counts twice": f / Z,
        },
    )
