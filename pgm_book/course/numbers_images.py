"""Questions with numbers on images: lessons 1, 2, 3 and 7."""

import numpy as np

from pgm_book.course.numbers import Chance, Numbers, listed, matrix
from pgm_book.program.lsm import row_shift
from pgm_book.program.registration import peak_of_parabola
from pgm_lab import frames, image, ncc
from pgm_lab.registration.accuracy import accuracy

SENSORS = [(4288, 2848), (6000, 4000), (1936, 1296), (8256, 5504), (5472, 3648)]

# --- 1: from pixel to photo ---


def photo_y(draw: Chance) -> Numbers:
    """The y of a pixel."""
    columns, rows = draw.of(SENSORS)
    p, row = draw(3, 9, 0.01), draw(40, rows - 40, 0.1)
    size = p / 1000
    y = frames.pixel_to_photo((0, row), (columns, rows), (size, size))[1]
    given = dict(n=columns, m=rows, p=p, row=row, centre=rows / 2 - 0.5)
    return given, y, [-y, y + size / 2, -row * size]


def pixel_column(draw: Chance) -> Numbers:
    """Back to the pixel."""
    columns, rows = draw.of(SENSORS)
    p = draw(3, 9, 0.01)
    size = p / 1000
    x = round(draw(-0.45, 0.45, 0.001) * columns * size, 3)
    column = frames.photo_to_pixel((x, 0), (columns, rows), (size, size))[0]
    given = dict(n=columns, m=rows, p=p, x=x, centre=columns / 2 - 0.5)
    return given, column, [column + 0.5, 2 * (columns / 2 - 0.5) - column, x / size]


def gsd(draw: Chance) -> Numbers:
    """Ground sampling distance."""
    p, c, H = draw(3, 9, 0.01), draw.of([18, 24, 35, 50]), draw(300, 2500, 10)
    answer = 100 * frames.ground_sampling_distance(p / 1000, H, c)
    return dict(p=p, c=c, H=H), answer, [0.1 * p * c / H, answer / 10, answer**2 / 100]


def flying_height(draw: Chance) -> Numbers:
    """Flying height."""
    p, c, d = draw(3, 9, 0.01), draw.of([18, 24, 35, 50]), draw(3, 40, 0.5)
    H = frames.flying_height(d / 100, p / 1000, c)
    return dict(p=p, c=c, d=d), H, [10000.0 * d / p / c, H / 1000, 100 * H]


def principal_point(draw: Chance) -> Numbers:
    """A forgotten principal point."""
    x0, y0, c = draw(0.03, 0.4, 0.01), draw(-0.3, -0.03, 0.01), draw.of([18, 24, 35])
    H = draw(500, 2500, 10)
    ground = [
        -H * ray[:2] / ray[2]
        for ray in (
            frames.interior_matrix(c, *at) @ (1, 1, 1) for at in ((x0, y0), (0, 0))
        )
    ]
    answer = np.hypot(*(ground[0] - ground[1]))
    return (
        dict(x0=x0, y0=y0, c=c, H=H, d=np.hypot(x0, y0)),
        answer,
        [x0 * H / c, (x0 + abs(y0)) * H / c, np.hypot(x0, y0)],
    )


def centroid(draw: Chance) -> Numbers:
    """Centroid of a target."""
    b = draw(20, 60)
    g = draw.several(9, b, b + 40).reshape(3, 3) + draw.several(1, 60, 120) * (
        np.arange(9).reshape(3, 3) == draw.of([4, 5])
    )
    X = image.centroid(g, background=b, sigma=1.0).position[0]
    w = g - b
    return (
        dict(
            b=b,
            g=matrix(g),
            s=listed(w.sum(axis=0)),
            one=w[:, 1].sum(),
            two=2 * w[:, 2].sum(),
            W=w.sum(),
        ),
        X,
        [g.sum(axis=0) @ range(3) / g.sum(), X + 1, w.sum(axis=1) @ range(3) / w.sum()],
    )


def centroid_sd(draw: Chance) -> Numbers:
    """Precision of a centroid."""
    n, W, s = draw.of([3, 5, 7, 9]), draw(200, 900, 10), draw(1, 4, 0.1)
    moment = n * sum((np.arange(n) - n // 2) ** 2)
    answer = s / W * np.sqrt(moment)
    return (
        dict(n=n, W=W, s=s, moment=moment),
        answer,
        [s / W * moment, answer / np.sqrt(n), s / W],
    )


def file_size(draw: Chance) -> Numbers:
    """Size of a photo file."""
    (columns, rows), bits = draw.of(SENSORS), draw.of([8, 10, 12, 14, 16])
    n, bands = draw(2, 40), draw.of([3, 4])
    answer = n * columns * rows * bands * bits / 8 / 2**20
    return (
        dict(c=columns, r=rows, b=bands, bits=bits, n=n),
        answer,
        [8 * answer, answer / bands, answer * 2**20 / 1000000.0],
    )


# --- 2: normalized cross correlation ---


def correlation(draw: Chance) -> Numbers:
    """The r of two windows."""
    T = draw.several(9, 20, 90).reshape(3, 3)
    S = (T + draw.several(9, -25, 25).reshape(3, 3)).clip(0)
    r = ncc.correlation(T, S)
    t, s = T - T.mean(), S - S.mean()
    given = dict(
        T=matrix(T),
        S=matrix(S),
        mt=T.mean(),
        ms=S.mean(),
        ts=np.sum(t * s),
        tt=np.sum(t * t),
        ss=np.sum(s * s),
    )
    slips = [
        np.sum(T * S) / np.sqrt(float(np.sum(T**2) * np.sum(S**2))),
        r * r,
        np.sum(t * s) / np.sum(t * t),
    ]
    return given, r, slips


def gained(draw: Chance) -> Numbers:
    """A gained window with one blemish."""
    T = draw.several(9, 10, 60).reshape(3, 3)
    h, k, e = draw.of([2, 3]), draw(5, 40), draw(40, 75, 5)
    S = h * T + k
    S[1, 1] += e
    r = ncc.correlation(T, S)
    t = T - T.mean()
    tt, ts = np.sum(t * t), np.sum(t * (S - S.mean()))
    given = dict(
        T=matrix(T),
        h=h,
        k=k,
        e=e,
        tt=tt,
        ts=ts,
        mid=t[1, 1],
        ss=np.sum((S - S.mean()) ** 2),
    )
    return given, r, [1, r * r, ts / tt / h]


def places(draw: Chance) -> Numbers:
    """Number of places."""
    T = draw(7, 41, 2)
    w, h = T + 2 * draw(5, 30), T + 2 * draw(2, 20)
    given = dict(T=T, w=w, h=h, a=w - T + 1, b=h - T + 1)
    slips = [(w - T) * (h - T), w * h, (w - T + 1) ** 2]
    return given, (w - T + 1) * (h - T + 1), slips


def search_width(draw: Chance) -> Numbers:
    """Width of the search window."""
    T, left, right = draw(7, 41, 2), draw(3, 60), draw(3, 60)
    reach = max(left, right)
    slips = [T + reach, T + left + right - (left == right), 2 * reach + 1]
    return dict(T=T, left=left, right=right, reach=reach), T + 2 * reach, slips


def map_to_photo(draw: Chance) -> Numbers:
    """From the map of r to the photo."""
    T, reach, start = draw(7, 41, 2), draw(8, 40), draw(200, 3000)
    k = draw(0, 2 * reach)
    S = T + 2 * reach
    given = dict(T=T, S=S, start=start, k=k, first=start - reach, reach=reach)
    slips = [start - S // 2 + k, start + k, start - reach + k + 1]
    return given, start - reach + k, slips


def gain(draw: Chance) -> Numbers:
    """Gain of a second photo."""
    x = draw.several(5, 20, 120, 5)
    y = np.rint(draw(0.4, 1.8, 0.1) * x).astype(int) + draw.several(5, 5, 25)
    found = ncc.regression(x, y)
    dx, dy = x - x.mean(), y - y.mean()
    given = dict(x=listed(x), y=listed(y), xy=np.sum(dx * dy), xx=np.sum(dx * dx))
    slips = [float(x @ y / (x @ x)), found.r, np.sum(dx * dy) / np.sum(dy * dy)]
    return given, found.beta, slips


def noisy(draw: Chance) -> Numbers:
    """The r of two noisy photos."""
    s, n = draw(10, 40), draw(3, 12, 0.5)
    r = s**2 / (s**2 + n**2)
    return dict(s=s, n=n), r, [s / np.hypot(s, n), s / (s + n), 1 - (n / s) ** 2]


# --- 3: least squares matching ---


def one_step(draw: Chance) -> Numbers:
    """One step of least squares."""
    A = np.cumsum(draw.several(5, 4, 22)) + draw(20, 60)
    B = A - draw.several(5, 2, 9)
    a = row_shift(A, B)
    slope, off = (B[2:] - B[:-2]) / 2, (A - B)[1:-1]
    given = dict(
        A=listed(A),
        B=listed(B),
        slope=listed(slope),
        off=listed(off),
        top=slope @ off,
        bottom=slope @ slope,
    )
    return given, a, [-a, a / 2, float(np.mean(off / slope))]


def shift_sd(draw: Chance) -> Numbers:
    """Precision of a shift."""
    slope, s = draw.several(6, -12, 12, 0.5), draw(1, 6, 0.1)
    slope[0] = draw(8, 12, 0.5)
    ss = slope @ slope
    answer = s / np.sqrt(ss)
    return (
        dict(slope=listed(slope), s=s, ss=ss),
        answer,
        [s / ss, answer * np.sqrt(6), s],
    )


def transformed(draw: Chance) -> Numbers:
    """Where a pixel goes."""
    a0, a1, a2 = draw(-2, 2, 0.01), draw(0.9, 1.1, 0.001), draw(-0.1, 0.1, 0.001)
    x, y = draw(-20, -5), draw(5, 20)
    answer = a0 + a1 * x + a2 * y
    return (
        dict(a0=a0, a1=a1, a2=a2, x=x, y=y),
        answer,
        [a0 + a2 * x + a1 * y, answer - a0, answer + x],
    )


def scale_of_window(draw: Chance) -> Numbers:
    """Scale in the parameters."""
    scale, turn = draw(0.85, 1.2, 0.01), np.radians(draw.of([-1, 1]) * draw(12, 35))
    a1 = round(float(scale * np.cos(turn)), 4)
    b1 = round(float(scale * np.sin(turn)), 4)
    return dict(a1=a1, b1=b1), np.hypot(a1, b1), [a1, a1**2 + b1**2, a1 + abs(b1)]


def bilinear(draw: Chance) -> Numbers:
    """A grey value between the pixels."""
    g = draw.several(4, 20, 220).reshape(2, 2)
    x, y = draw(0.1, 0.45, 0.05), draw(0.55, 0.9, 0.05)
    answer = float(image.resample(g.astype(float), (x, y), method="bilinear"))
    top, bottom = (1 - x) * g[0, 0] + x * g[0, 1], (1 - x) * g[1, 0] + x * g[1, 1]
    return (
        dict(g=matrix(g), x=x, y=y, top=top, bottom=bottom),
        answer,
        [
            float(image.resample(g.astype(float), (y, x), method="bilinear")),
            float(image.resample(g.astype(float), (1 - x, 1 - y), "bilinear")),
            g[1, 0],
        ],
    )


def brightness(draw: Chance) -> Numbers:
    """Contrast and brightness."""
    mA, mB = draw(60, 160, 0.5), draw(60, 160, 0.5)
    sA, sB = draw(12, 30, 0.5), draw(15, 30, 0.5)
    h1 = sA / sB
    answer = mA - h1 * mB
    return (
        dict(mA=mA, mB=mB, sA=sA, sB=sB, h1=h1),
        answer,
        [mA - mB / h1, mA - mB, mB - h1 * mA],
    )


def match_sigma0(draw: Chance) -> Numbers:
    """The sigma0 of a match."""
    n, vv, u = draw.of([5, 7]), draw(600, 9000, 10), draw.of([6, 8])
    r = n * n - u
    answer = np.sqrt(vv / r)
    return (
        dict(n=n, vv=vv, u=u, r=r),
        answer,
        [np.sqrt(vv) / r, np.sqrt(vv / n**2), vv / r],
    )


# --- 7: Pearson registration ---


def from_sums(draw: Chance) -> Numbers:
    """The r from sums."""
    X = draw.several(9, 10, 60)
    Y = X + draw.several(9, -15, 25)
    sums = dict(X=X.sum(), Y=Y.sum(), XX=X @ X, YY=Y @ Y, XY=X @ Y)
    top = 9 * (X @ Y) - X.sum() * Y.sum()
    x2, y2 = 9 * (X @ X) - X.sum() ** 2, 9 * (Y @ Y) - Y.sum() ** 2
    r = ncc.correlation(X.reshape(3, 3), Y.reshape(3, 3))
    given = {**{k: int(v) for k, v in sums.items()}, "top": top, "x2": x2, "y2": y2}
    slips = [sums["XY"] / np.sqrt(float(sums["XX"] * sums["YY"])), r * r, top / x2]
    return given, r, slips


def rmse_t(draw: Chance) -> Numbers:
    """RMSE of some chips."""
    dx, dy = draw.several(4, -1, 4), draw.several(4, -3, 2)
    g = draw.of([6, 10, 15, 30])
    found = accuracy(dx.astype(float), dy.astype(float)).times(g)
    xx, yy = int(dx @ dx), int(dy @ dy)
    given = dict(dx=listed(dx), dy=listed(dy), g=g, xx=xx, yy=yy, px=found.rmse_t / g)
    slips = [
        found.rmse_t * np.sqrt(4 / 3),
        g * np.sqrt(dx.var() + dy.var()),
        found.rmse_t / np.sqrt(2),
    ]
    return given, found.rmse_t, slips


def parabola(draw: Chance) -> Numbers:
    """The peak between the pixels."""
    middle = draw(0.85, 0.98, 0.01)
    left, right = middle - draw(0.02, 0.4, 0.01), middle - draw(0.02, 0.4, 0.01)
    left, right = round(left, 2), round(right, 2)
    answer = peak_of_parabola(left, middle, right)
    return (
        dict(left=left, middle=middle, right=right),
        answer,
        [-answer, 2 * answer, right - left],
    )


def scatter(draw: Chance) -> Numbers:
    """Mean and scatter."""
    mean = draw(0.5, 3, 0.05)
    rmse = round(mean + draw(0.2, 2, 0.05), 2)
    answer = np.sqrt(rmse**2 - mean**2)
    return dict(mean=mean, rmse=rmse), answer, [rmse - mean, np.hypot(rmse, mean), rmse]


def affine(draw: Chance) -> Numbers:
    """An affine shift on the ground."""
    a, b = draw.several(3, -2, 2, 0.1), draw.several(3, -2, 2, 0.1)
    x, y, g = draw(200, 1500, 10), draw(200, 1500, 10), draw.of([6, 10, 30])
    dx, dy = a @ (1, x / 1000, y / 1000), b @ (1, x / 1000, y / 1000)
    answer = g * np.hypot(dx, dy)
    return (
        dict(a=listed(a), b=listed(b), x=x, y=y, g=g, dx=dx, dy=dy),
        answer,
        [
            g * np.hypot(a[0], b[0]),
            g * (abs(dx) + abs(dy)),
            g * np.hypot(a @ (1, y / 1000, x / 1000), b @ (1, y / 1000, x / 1000)),
        ],
    )


def ce90(draw: Chance) -> Numbers:
    """Circular error."""
    rmse = draw(4, 30, 0.1)
    answer = rmse * np.sqrt(np.log(10))
    return (
        dict(rmse=rmse),
        answer,
        [rmse / np.sqrt(np.log(10)), rmse * np.sqrt(2 * np.log(10)), 1.645 * rmse],
    )


def whole_pixels(draw: Chance) -> Numbers:
    """What whole pixels cost."""
    dx, dy = draw(0.55, 3.45, 0.1), draw(-3.45, -0.55, 0.1)
    g = draw.of([6, 10, 15, 30])
    off = np.array([dx - round(dx), dy - round(dy)])
    answer = g * np.hypot(*off)
    return (
        dict(dx=dx, dy=dy, g=g, x=abs(off[0]), y=abs(off[1])),
        answer,
        [
            g * np.hypot(dx, dy),
            g * np.abs(off).sum(),
            g * np.hypot(round(dx), round(dy)),
        ],
    )
