"""Questions with numbers on images: lessons 1, 2, 3 and 7."""

import numpy as np

from pgm_book.course.numbers import Asked, Chance, listed, matrix, question
from pgm_book.program.lsm import row_shift
from pgm_book.program.registration import peak_of_parabola
from pgm_lab import frames, image, ncc
from pgm_lab.registration.accuracy import accuracy

SENSORS = [(4288, 2848), (6000, 4000), (1936, 1296), (8256, 5504), (5472, 3648)]

# --- 1: from pixel to photo ---


@question("1", "The y of a pixel", "mm", 3)
def photo_y(draw: Chance) -> Asked:
    columns, rows = draw.of(SENSORS)
    p, row = draw(3, 9, 0.01), draw(40, rows - 40, 0.1)
    size = p / 1000
    y = frames.pixel_to_photo((0, row), (columns, rows), (size, size))[1]
    return Asked(
        dict(n=columns, m=rows, p=p, row=row, centre=rows / 2 - 0.5),
        "A photo has %(n)d × %(m)d pixels of %(p)g µm. A target lies in row %(row)g; "
        "whole numbers, from 0, are pixel centres. What is its photo coordinate $y$?",
        y,
        r"$Y_c = %(m)d/2 - 0.5 = %(centre)g$ and, since $y$ points up, "
        r"$y = (Y_c - Y)\,p = (%(centre)g - %(row)g) \cdot %(p)g / 1000 = %(answer)s$ "
        "mm (B 2.3b, 2.4b, with the sign that the source lost).",
        {
            "y points up, rows count downwards": -y,
            "the centre is n/2 - 0.5, not n/2": y + size / 2,
            "y counts from the centre, not from the first row": -row * size,
        },
    )


@question("1", "Back to the pixel", "", 1)
def pixel_column(draw: Chance) -> Asked:
    columns, rows = draw.of(SENSORS)
    p = draw(3, 9, 0.01)
    size = p / 1000
    x = round(draw(-0.45, 0.45, 0.001) * columns * size, 3)
    column = frames.photo_to_pixel((x, 0), (columns, rows), (size, size))[0]
    return Asked(
        dict(n=columns, m=rows, p=p, x=x, centre=columns / 2 - 0.5),
        "A photo has %(n)d × %(m)d pixels of %(p)g µm; whole numbers, from 0, are pixel "
        "centres. A computed point has $x = %(x)g$ mm. In which column is it marked?",
        column,
        r"$X = x / p + X_c = %(x)g / %(p)g \cdot 1000 + %(centre)g = %(answer)s$, with "
        r"$X_c = %(n)d/2 - 0.5$ (B 2.4a, 2.5a).",
        {
            "the centre is n/2 - 0.5, not n/2": column + 0.5,
            "columns grow to the right, as x does": 2 * (columns / 2 - 0.5) - column,
            "columns count from the left edge": x / size,
        },
    )


@question("1", "Ground sampling distance", "cm", 1)
def gsd(draw: Chance) -> Asked:
    p, c, H = draw(3, 9, 0.01), draw.of([18, 24, 35, 50]), draw(300, 2500, 10)
    answer = 100 * frames.ground_sampling_distance(p / 1000, H, c)
    return Asked(
        dict(p=p, c=c, H=H),
        "A camera with pixels of %(p)g µm and $c = %(c)g$ mm looks straight down from "
        "%(H)g m above the ground. How large is its ground sampling distance?",
        answer,
        r"$\mathrm{GSD} = p\,H/c = %(p)g\ \text{µm} \cdot %(H)g\ \text{m} / %(c)g\ "
        r"\text{mm} = %(answer)s$ cm.",
        {
            "H/c is the scale number, not c/H": 1e-1 * p * c / H,
            "a millimetre has 1000 µm": answer / 10,
            "a pixel on the ground is a length, not an area": answer**2 / 100,
        },
    )


@question("1", "How high to fly", "m", 1)
def flying_height(draw: Chance) -> Asked:
    p, c, d = draw(3, 9, 0.01), draw.of([18, 24, 35, 50]), draw(3, 40, 0.5)
    H = frames.flying_height(d / 100, p / 1000, c)
    return Asked(
        dict(p=p, c=c, d=d),
        "A client wants a ground sampling distance of %(d)g cm. The camera has pixels of "
        "%(p)g µm and $c = %(c)g$ mm. How high above the ground may you fly?",
        H,
        r"From $\mathrm{GSD} = p\,H/c$ follows $H = c\,\mathrm{GSD}/p = %(c)g\ "
        r"\text{mm} \cdot %(d)g\ \text{cm} / %(p)g\ \text{µm} = %(answer)s$ m.",
        {
            "H grows with c": 1e4 * d / p / c,
            "a millimetre has 1000 µm": H / 1000,
            "a metre has 100 cm": 100 * H,
        },
    )


@question("1", "A forgotten principal point", "m", 2)
def principal_point(draw: Chance) -> Asked:
    x0, y0, c = draw(0.03, 0.4, 0.01), draw(-0.3, -0.03, 0.01), draw.of([18, 24, 35])
    H = draw(500, 2500, 10)
    ground = [
        -H * ray[:2] / ray[2]
        for ray in (
            frames.interior_matrix(c, *at) @ (1, 1, 1) for at in ((x0, y0), (0, 0))
        )
    ]
    answer = np.hypot(*(ground[0] - ground[1]))
    return Asked(
        dict(x0=x0, y0=y0, c=c, H=H, d=np.hypot(x0, y0)),
        "A camera looks straight down from %(H)g m with $c = %(c)g$ mm. Somebody takes "
        "the image centre for the principal point, which lies at $x_0 = %(x0)g$ mm, "
        "$y_0 = %(y0)g$ mm. How far is each ground point off?",
        answer,
        r"The photo is off by $\sqrt{x_0^2 + y_0^2} = %(d).4f$ mm (M 2.1); the ground is "
        r"$H/c$ times as large: $%(d).4f\ \text{mm} \cdot %(H)g\ \text{m} / %(c)g\ "
        r"\text{mm} = %(answer)s$ m.",
        {
            "both coordinates count": x0 * H / c,
            "lengths add as squares": (x0 + abs(y0)) * H / c,
            "the scale number is H/c": np.hypot(x0, y0),
        },
    )


@question("1", "Centroid of a target", "", 3)
def centroid(draw: Chance) -> Asked:
    b = draw(20, 60)
    g = draw.several(9, b, b + 40).reshape(3, 3) + draw.several(1, 60, 120) * (
        np.arange(9).reshape(3, 3) == draw.of([4, 5])
    )
    X = image.centroid(g, background=b, sigma=1.0).position[0]
    w = g - b
    return Asked(
        dict(
            b=b,
            g=matrix(g),
            s=listed(w.sum(axis=0)),
            one=w[:, 1].sum(),
            two=2 * w[:, 2].sum(),
            W=w.sum(),
        ),
        "A target in a window of 3 × 3 pixels has the grey values $%(g)s$ on a "
        "background of %(b)g. In which column lies its centroid? Columns count from 0.",
        X,
        r"Without the background the columns have the sums $%(s)s$, together "
        r"$W = %(W)g$. $X = \sum j\,w / W = (0 + %(one)g + %(two)g) / %(W)g = "
        r"%(answer)s$ (M 2.15).",
        {
            "the background is subtracted first": g.sum(axis=0) @ range(3) / g.sum(),
            "columns count from 0": X + 1,
            "X belongs to the columns, Y to the rows": w.sum(axis=1)
            @ range(3)
            / w.sum(),
        },
    )


@question("1", "How good is a centroid?", "px", 4)
def centroid_sd(draw: Chance) -> Asked:
    n, W, s = draw.of([3, 5, 7, 9]), draw(200, 900, 10), draw(1, 4, 0.1)
    moment = n * sum((np.arange(n) - n // 2) ** 2)
    answer = s / W * np.sqrt(moment)
    return Asked(
        dict(n=n, W=W, s=s, moment=moment),
        "A target stands in the middle of a window of %(n)d × %(n)d pixels; its weights "
        "add up to $W = %(W)g$ grey values. Every pixel has noise with a standard "
        "deviation of %(s)g grey values, and the background is known exactly. What is "
        "the standard deviation of the column of its centroid?",
        answer,
        r"Over all pixels $\sum (j - X)^2 = %(moment)d$, so $\sigma_X = \frac{\sigma}{W} "
        r"\sqrt{\sum (j - X)^2} = %(s)g / %(W)g \cdot \sqrt{%(moment)d} = %(answer)s$ "
        "px.",
        {
            "the sum stands under a root": s / W * moment,
            "the sum runs over all rows": answer / np.sqrt(n),
            "noise of all pixels adds up, weighted by the lever": s / W,
        },
    )


@question("1", "Size of a photo file", "MiB", 1)
def file_size(draw: Chance) -> Asked:
    (columns, rows), bits = draw.of(SENSORS), draw.of([8, 10, 12, 14, 16])
    n, bands = draw(2, 40), draw.of([3, 4])
    answer = n * columns * rows * bands * bits / 8 / 2**20
    return Asked(
        dict(c=columns, r=rows, b=bands, bits=bits, n=n),
        "How large are %(n)d uncompressed photos of %(c)d × %(r)d pixels, with %(b)d "
        "bands of %(bits)d bit each, packed without gaps? A MiB has $2^{20}$ bytes.",
        answer,
        r"$%(n)d \cdot %(c)d \cdot %(r)d \cdot %(b)d \cdot %(bits)d / 8 / 2^{20} = "
        "%(answer)s$ MiB.",
        {
            "a byte has 8 bits": 8 * answer,
            "every band counts": answer / bands,
            "a MiB has 2^20 bytes, not a million": answer * 2**20 / 1e6,
        },
    )


# --- 2: normalized cross correlation ---


@question("2", "r by hand", "", 3)
def correlation(draw: Chance) -> Asked:
    T = draw.several(9, 20, 90).reshape(3, 3)
    S = (T + draw.several(9, -25, 25).reshape(3, 3)).clip(0)
    r = ncc.correlation(T, S)
    t, s = T - T.mean(), S - S.mean()
    return Asked(
        dict(
            T=matrix(T),
            S=matrix(S),
            mt=T.mean(),
            ms=S.mean(),
            ts=np.sum(t * s),
            tt=np.sum(t * t),
            ss=np.sum(s * s),
        ),
        "How similar are $T = %(T)s$ and $S = %(S)s$? Compute their correlation "
        "coefficient $r$.",
        r,
        r"The means are $\bar g_T = %(mt).4f$ and $\bar g_S = %(ms).4f$. The deviations "
        r"from them give $\sum (g_T - \bar g_T)(g_S - \bar g_S) = %(ts).3f$, and the "
        r"squares $%(tt).3f$ and $%(ss).3f$. $r = %(ts).3f / \sqrt{%(tt).3f \cdot "
        r"%(ss).3f} = %(answer)s$ (B 2.6f).",
        {
            "the means are subtracted first": np.sum(T * S)
            / np.sqrt(float(np.sum(T**2) * np.sum(S**2))),
            "this is r squared": r * r,
            "the product of the sums stands under a root": np.sum(t * s)
            / np.sum(t * t),
        },
    )


@question("2", "A gained window with one blemish", "", 3)
def gained(draw: Chance) -> Asked:
    T = draw.several(9, 10, 60).reshape(3, 3)
    h, k, e = draw.of([2, 3]), draw(5, 40), draw(40, 75, 5)
    S = h * T + k
    S[1, 1] += e
    r = ncc.correlation(T, S)
    t = T - T.mean()
    tt, ts = np.sum(t * t), np.sum(t * (S - S.mean()))
    return Asked(
        dict(
            T=matrix(T),
            h=h,
            k=k,
            e=e,
            tt=tt,
            ts=ts,
            mid=t[1, 1],
            ss=np.sum((S - S.mean()) ** 2),
        ),
        "A second photo shows the window $T = %(T)s$ with %(h)d times the contrast, "
        "%(k)d grey values brighter, and with a blemish: its middle pixel is %(e)d grey "
        "values too bright. What is $r$ of the two windows?",
        r,
        r"Gain and offset would leave $r = 1$. With $\sum (g_T - \bar g_T)^2 = %(tt).3f$ "
        r"and the deviation %(mid).4f of the middle pixel, the sum of products is "
        r"$%(h)d \cdot %(tt).3f + %(e)d \cdot (%(mid).4f) = %(ts).3f$, and the sum of "
        r"squares of the second window $%(h)d^2 \cdot %(tt).3f + 2 \cdot %(h)d \cdot "
        r"%(e)d \cdot (%(mid).4f) + %(e)d^2 \cdot \frac{8}{9} = %(ss).3f$. $r = "
        r"%(ts).3f / \sqrt{%(tt).3f \cdot %(ss).3f} = %(answer)s$ (B 2.6f).",
        {
            "the blemish changes r": 1,
            "this is r squared": r * r,
            "the contrast of the second window counts too": ts / tt / h,
        },
    )


@question("2", "How many places?", "", 0)
def places(draw: Chance) -> Asked:
    T = draw(7, 41, 2)
    w, h = T + 2 * draw(5, 30), T + 2 * draw(2, 20)
    return Asked(
        dict(T=T, w=w, h=h, a=w - T + 1, b=h - T + 1),
        "A template of %(T)d × %(T)d pixels is moved over a search window of %(w)d "
        "columns and %(h)d rows, and must lie within it. At how many places is $r$ "
        "computed?",
        (w - T + 1) * (h - T + 1),
        r"$(%(w)d - %(T)d + 1)(%(h)d - %(T)d + 1) = %(a)d \cdot %(b)d = %(answer)s$.",
        {
            "both ends count: plus one": (w - T) * (h - T),
            "the template must lie within the window": w * h,
            "the rows differ from the columns": (w - T + 1) ** 2,
        },
    )


@question("2", "Width of the search window", "px", 0)
def search_width(draw: Chance) -> Asked:
    T, left, right = draw(7, 41, 2), draw(3, 60), draw(3, 60)
    reach = max(left, right)
    return Asked(
        dict(T=T, left=left, right=right, reach=reach),
        "A match may lie up to %(left)d px to the left of its start and up to %(right)d "
        "px to the right. The search window is centred at the start. How wide must it "
        "be at least for a template %(T)d pixels wide?",
        T + 2 * reach,
        r"It must reach %(reach)d px to both sides, and contain the template there: "
        r"$%(T)d + 2 \cdot %(reach)d = %(answer)s$ px.",
        {
            "the window reaches to both sides": T + reach,
            "a centred window reaches equally far": T + left + right - (left == right),
            "the template must fit in": 2 * reach + 1,
        },
    )


@question("2", "From the map of r to the photo", "", 0)
def map_to_photo(draw: Chance) -> Asked:
    T, reach, start = draw(7, 41, 2), draw(8, 40), draw(200, 3000)
    k = draw(0, 2 * reach)
    S = T + 2 * reach
    return Asked(
        dict(T=T, S=S, start=start, k=k, first=start - reach, reach=reach),
        "A template of %(T)d × %(T)d pixels is searched in a window of %(S)d × %(S)d "
        "pixels, centred at column %(start)d of the right photo. The highest $r$ stands "
        "in column %(k)d of the map, counted from 0. Which column of the right photo is "
        "the centre of the match?",
        start - reach + k,
        r"At column 0 of the map the template's centre is $(%(S)d - %(T)d)/2 = "
        r"%(reach)d$ px left of the start, in column %(first)d. The match is "
        r"$%(first)d + %(k)d = %(answer)s$.",
        {
            "the map begins half a template inside the window": start - S // 2 + k,
            "column 0 of the map is not the start": start + k,
            "columns count from 0": start - reach + k + 1,
        },
    )


@question("2", "Gain of a second photo", "", 3)
def gain(draw: Chance) -> Asked:
    x = draw.several(5, 20, 120, 5)
    y = np.rint(draw(0.4, 1.8, 0.1) * x).astype(int) + draw.several(5, 5, 25)
    found = ncc.regression(x, y)
    dx, dy = x - x.mean(), y - y.mean()
    return Asked(
        dict(x=listed(x), y=listed(y), xy=np.sum(dx * dy), xx=np.sum(dx * dx)),
        "Five pixels have the grey values $x = %(x)s$ in the left photo and $y = %(y)s$ "
        r"in the right one. Which gain $\beta$ does the regression $y \approx \alpha + "
        r"\beta x$ give?",
        found.beta,
        r"$\beta = s_{xy}/s_x^2 = \sum (x - \bar x)(y - \bar y) / \sum (x - \bar x)^2 = "
        "%(xy).1f / %(xx).1f = %(answer)s$ (B 2.6d).",
        {
            "the line has an offset": float(x @ y / (x @ x)),
            "this is r": found.r,
            "divide by the spread of x": np.sum(dx * dy) / np.sum(dy * dy),
        },
    )


@question("2", "r of two noisy photos", "", 3)
def noisy(draw: Chance) -> Asked:
    s, n = draw(10, 40), draw(3, 12, 0.5)
    r = s**2 / (s**2 + n**2)
    return Asked(
        dict(s=s, n=n),
        "Two photos show the same texture, with a standard deviation of %(s)g grey "
        "values. Each photo has independent noise of %(n)g grey values. Which $r$ is to "
        "be expected of two large windows at the right place?",
        r,
        r"Only the texture is common: $r = s^2 / (s^2 + \sigma^2) = %(s)g^2 / (%(s)g^2 + "
        "%(n)g^2) = %(answer)s$.",
        {
            "both photos are noisy": s / np.hypot(s, n),
            "variances add, not standard deviations": s / (s + n),
            "the noise is part of each window's contrast": 1 - (n / s) ** 2,
        },
    )


# --- 3: least squares matching ---


@question("3", "One step of least squares", "px", 3)
def one_step(draw: Chance) -> Asked:
    A = np.cumsum(draw.several(5, 4, 22)) + draw(20, 60)
    B = A - draw.several(5, 2, 9)
    a = row_shift(A, B)
    slope, off = (B[2:] - B[:-2]) / 2, (A - B)[1:-1]
    return Asked(
        dict(
            A=listed(A),
            B=listed(B),
            slope=listed(slope),
            off=listed(off),
            top=slope @ off,
            bottom=slope @ slope,
        ),
        "A row of the left photo has the grey values $A = %(A)s$, the same row of the "
        "right photo $B = %(B)s$. Which shift $a$, positive where B lies to the right "
        "of A, does one step of least squares give? The three inner pixels count.",
        a,
        r"The slopes are $B_x = \frac12(B(x+1) - B(x-1)) = %(slope)s$ (B 2.12), the "
        r"differences $A - B = %(off)s$. From $B_x\,a = A - B$ follows $a = \sum B_x "
        r"(A - B) / \sum B_x^2 = %(top).2f / %(bottom).2f = %(answer)s$ px.",
        {
            "A minus B, not B minus A": -a,
            "a slope is half the difference of the neighbours": a / 2,
            "the slopes are weights, not divisors": float(np.mean(off / slope)),
        },
    )


@question("3", "How precise is the shift?", "px", 4)
def shift_sd(draw: Chance) -> Asked:
    slope, s = draw.several(6, -12, 12, 0.5), draw(1, 6, 0.1)
    slope[0] = draw(8, 12, 0.5)
    ss = slope @ slope
    answer = s / np.sqrt(ss)
    return Asked(
        dict(slope=listed(slope), s=s, ss=ss),
        "Six pixels of a row have the slopes $B_x = %(slope)s$ grey values a pixel. The "
        r"adjustment of the shift alone gives $\sigma_0 = %(s)g$ grey values. What is "
        "the standard deviation of the shift?",
        answer,
        r"$N = \sum B_x^2 = %(ss)g$ and $\sigma_a = \sigma_0 / \sqrt{N} = %(s)g / "
        r"\sqrt{%(ss)g} = %(answer)s$ px.",
        {
            "a standard deviation has a root": s / ss,
            "the squares are added, not averaged": answer * np.sqrt(6),
            "sigma0 is no shift": s,
        },
    )


@question("3", "Where a pixel goes", "px", 3)
def transformed(draw: Chance) -> Asked:
    a0, a1, a2 = draw(-2, 2, 0.01), draw(0.9, 1.1, 0.001), draw(-0.1, 0.1, 0.001)
    x, y = draw(-20, -5), draw(5, 20)
    answer = a0 + a1 * x + a2 * y
    return Asked(
        dict(a0=a0, a1=a1, a2=a2, x=x, y=y),
        "Least squares matching found $a_0 = %(a0)g$ px, $a_1 = %(a1)g$ and $a_2 = "
        "%(a2)g$. To which $x'$, counted from the centre of the start, does the pixel "
        "$x = %(x)d$, $y = %(y)d$ of the window go?",
        answer,
        r"$x' = a_0 + a_1 x + a_2 y = %(a0)g + %(a1)g \cdot (%(x)d) + (%(a2)g) \cdot "
        "%(y)d = %(answer)s$ px (B 2.8).",
        {
            "a1 belongs to x, a2 to y": a0 + a2 * x + a1 * y,
            "the shift counts too": answer - a0,
            "the parameters are no corrections to x": answer + x,
        },
    )


@question("3", "Scale in the parameters", "", 4)
def scale_of_window(draw: Chance) -> Asked:
    scale, turn = draw(0.85, 1.2, 0.01), np.radians(draw.of([-1, 1]) * draw(12, 35))
    a1 = round(float(scale * np.cos(turn)), 4)
    b1 = round(float(scale * np.sin(turn)), 4)
    return Asked(
        dict(a1=a1, b1=b1, a2=-b1),
        "A window was rotated and enlarged, and nothing else. Least squares matching "
        "gives $a_1 = b_2 = %(a1).4f$ and $b_1 = -a_2 = %(b1).4f$. By which factor was "
        "it enlarged?",
        np.hypot(a1, b1),
        r"$a_1$ and $b_2$ hold the scale times the cosine, $b_1$ and $-a_2$ the scale "
        r"times the sine of the rotation (B 2.8, 2.9). $\sqrt{%(a1).4f^2 + (%(b1).4f)^2} "
        "= %(answer)s$.",
        {
            "a1 is the scale times the cosine": a1,
            "this is the scale of areas": a1**2 + b1**2,
            "cosine and sine add as squares": a1 + abs(b1),
        },
    )


@question("3", "A grey value between the pixels", "grey values", 2)
def bilinear(draw: Chance) -> Asked:
    g = draw.several(4, 20, 220).reshape(2, 2)
    x, y = draw(0.1, 0.45, 0.05), draw(0.55, 0.9, 0.05)
    answer = float(image.resample(g.astype(float), (x, y), method="bilinear"))
    top, bottom = (1 - x) * g[0, 0] + x * g[0, 1], (1 - x) * g[1, 0] + x * g[1, 1]
    return Asked(
        dict(g=matrix(g), x=x, y=y, top=top, bottom=bottom),
        "The pixels $%(g)s$ have columns 0 and 1 and rows 0 and 1. Interpolate "
        "bilinearly the grey value in column %(x)g, row %(y)g.",
        answer,
        "Along the columns: %(top).3f in row 0 and %(bottom).3f in row 1. Between the "
        r"rows: $(1 - %(y)g) \cdot %(top).3f + %(y)g \cdot %(bottom).3f = %(answer)s$ "
        "grey values.",
        {
            "first the column, then the row": float(
                image.resample(g.astype(float), (y, x), method="bilinear")
            ),
            "the nearer pixel has the larger weight": float(
                image.resample(g.astype(float), (1 - x, 1 - y), "bilinear")
            ),
            "this is the nearest pixel": g[1, 0],
        },
    )


@question("3", "Contrast and brightness", "grey values", 2)
def brightness(draw: Chance) -> Asked:
    mA, mB = draw(60, 160, 0.5), draw(60, 160, 0.5)
    sA, sB = draw(12, 30, 0.5), draw(15, 30, 0.5)
    h1 = sA / sB
    answer = mA - h1 * mB
    return Asked(
        dict(mA=mA, mB=mB, sA=sA, sB=sB, h1=h1),
        r"Two windows fit, up to $A = h_0 + h_1 B$. Window $A$ has the mean %(mA)g and "
        "the standard deviation %(sA)g grey values, window $B$ %(mB)g and %(sB)g; "
        "$h_1$ is positive, and there is no noise. How large is $h_0$?",
        answer,
        r"$h_1 = %(sA)g / %(sB)g = %(h1).5f$, and $h_0 = \bar A - h_1 \bar B = %(mA)g - "
        r"%(h1).5f \cdot %(mB)g = %(answer)s$ grey values (B 2.7).",
        {
            "h1 is the contrast of A over that of B": mA - mB / h1,
            "the gain acts on the mean too": mA - mB,
            "h1 times B leads to A, not the other way": mB - h1 * mA,
        },
    )


@question("3", "The sigma0 of a match", "grey values", 2)
def match_sigma0(draw: Chance) -> Asked:
    n, vv, u = draw.of([5, 7]), draw(600, 9000, 10), draw.of([6, 8])
    r = n * n - u
    answer = np.sqrt(vv / r)
    return Asked(
        dict(n=n, vv=vv, u=u, r=r, nn=n * n),
        "A window of %(n)d × %(n)d pixels is matched with %(u)d parameters; all pixels "
        r"count. The squares of the residuals add up to %(vv)d. How large is $\sigma_0$?",
        answer,
        r"The redundancy is $%(n)d^2 - %(u)d = %(r)d$, and $\sigma_0 = \sqrt{v^Tv / r} = "
        r"\sqrt{%(vv)d / %(r)d} = %(answer)s$ grey values.",
        {
            "the root reaches over the redundancy": np.sqrt(vv) / r,
            "the parameters are subtracted": np.sqrt(vv / n**2),
            "this is the square": vv / r,
        },
    )


# --- 7: Pearson registration ---


@question("7", "r from the sums", "", 3)
def from_sums(draw: Chance) -> Asked:
    X = draw.several(9, 10, 60)
    Y = X + draw.several(9, -15, 25)
    sums = dict(X=X.sum(), Y=Y.sum(), XX=X @ X, YY=Y @ Y, XY=X @ Y)
    top = 9 * (X @ Y) - X.sum() * Y.sum()
    x2, y2 = 9 * (X @ X) - X.sum() ** 2, 9 * (Y @ Y) - Y.sum() ** 2
    r = ncc.correlation(X.reshape(3, 3), Y.reshape(3, 3))
    return Asked(
        {**{k: int(v) for k, v in sums.items()}, "top": top, "x2": x2, "y2": y2},
        r"Over the nine pixels of a chip, $\sum X = %(X)d$, $\sum Y = %(Y)d$, $\sum X^2 "
        r"= %(XX)d$, $\sum Y^2 = %(YY)d$ and $\sum XY = %(XY)d$. What is $r$?",
        r,
        r"$N \sum XY - \sum X \sum Y = 9 \cdot %(XY)d - %(X)d \cdot %(Y)d = %(top)d$. "
        r"Under the root stand $9 \cdot %(XX)d - %(X)d^2 = %(x2)d$ and $9 \cdot %(YY)d - "
        r"%(Y)d^2 = %(y2)d$. $r = %(top)d / \sqrt{%(x2)d \cdot %(y2)d} = %(answer)s$ "
        "(Br 1).",
        {
            "the products of the sums are subtracted": sums["XY"]
            / np.sqrt(float(sums["XX"] * sums["YY"])),
            "this is r squared": r * r,
            "both spreads stand under the root": top / x2,
        },
    )


@question("7", "RMSE of some chips", "m", 2)
def rmse_t(draw: Chance) -> Asked:
    dx, dy = draw.several(4, -1, 4), draw.several(4, -3, 2)
    g = draw.of([6, 10, 15, 30])
    found = accuracy(dx.astype(float), dy.astype(float)).times(g)
    xx, yy = int(dx @ dx), int(dy @ dy)
    return Asked(
        dict(dx=listed(dx), dy=listed(dy), g=g, xx=xx, yy=yy, px=found.rmse_t / g),
        "Four chips report the shifts $dx = %(dx)s$ and $dy = %(dy)s$ pixels of %(g)d m. "
        r"How large is $\mathrm{RMSE}_T$?",
        found.rmse_t,
        r"$\mathrm{RMSE}_T = \sqrt{(\sum dx^2 + \sum dy^2)/n} = \sqrt{(%(xx)d + %(yy)d) "
        r"/ 4} = %(px).4f$ px (Br 2–4), times %(g)d m: %(answer)s m.",
        {
            "n counts, not n - 1": found.rmse_t * np.sqrt(4 / 3),
            "the mean shift is part of it": g * np.sqrt(dx.var() + dy.var()),
            "each chip has two coordinates, but counts once": found.rmse_t / np.sqrt(2),
        },
    )


@question("7", "The peak between the pixels", "px", 3)
def parabola(draw: Chance) -> Asked:
    middle = draw(0.85, 0.98, 0.01)
    left, right = middle - draw(0.02, 0.4, 0.01), middle - draw(0.02, 0.4, 0.01)
    left, right = round(left, 2), round(right, 2)
    answer = peak_of_parabola(left, middle, right)
    return Asked(
        dict(left=left, middle=middle, right=right),
        "Along a row the map of $r$ has the values %(left)g, %(middle)g and %(right)g; "
        "the middle one is the highest. How far to the right of it is the peak of the "
        "parabola through all three?",
        answer,
        r"$(r_+ - r_-) / (2\,(2 r_0 - r_- - r_+)) = (%(right)g - %(left)g) / (2\,(2 "
        r"\cdot %(middle)g - %(left)g - %(right)g)) = %(answer)s$ px.",
        {
            "the peak lies on the side of the higher neighbour": -answer,
            "the denominator has a factor two": 2 * answer,
            "neighbours compare with the middle": right - left,
        },
    )


@question("7", "Mean and scatter", "px", 2)
def scatter(draw: Chance) -> Asked:
    mean = draw(0.5, 3, 0.05)
    rmse = round(mean + draw(0.2, 2, 0.05), 2)
    answer = np.sqrt(rmse**2 - mean**2)
    return Asked(
        dict(mean=mean, rmse=rmse),
        r"Many chips have $\mathrm{RMSE}_x = %(rmse)g$ px, and the mean of their $dx$ is "
        "%(mean)g px. How much do they scatter about this mean (root mean square)?",
        answer,
        r"$\mathrm{RMSE}_x^2 = \bar d^2 + \frac1n \sum v_i^2$, so the scatter is "
        r"$\sqrt{%(rmse)g^2 - %(mean)g^2} = %(answer)s$ px.",
        {
            "squares are subtracted, not lengths": rmse - mean,
            "the mean is a part of RMSE": np.hypot(rmse, mean),
            "RMSE mixes mean and scatter": rmse,
        },
    )


@question("7", "An affine shift on the ground", "m", 1)
def affine(draw: Chance) -> Asked:
    a, b = draw.several(3, -2, 2, 0.1), draw.several(3, -2, 2, 0.1)
    x, y, g = draw(200, 1500, 10), draw(200, 1500, 10), draw.of([6, 10, 30])
    dx, dy = a @ (1, x / 1000, y / 1000), b @ (1, x / 1000, y / 1000)
    answer = g * np.hypot(dx, dy)
    return Asked(
        dict(a=listed(a), b=listed(b), x=x, y=y, g=g, dx=dx, dy=dy),
        "Two images differ by $dx = a_0 + a_1 x + a_2 y$ and $dy = b_0 + b_1 x + b_2 y$ "
        "in pixels of %(g)d m, with $x$ and $y$ in **thousands** of pixels; $a = %(a)s$ "
        "and $b = %(b)s$. How far apart on the ground are they at column %(x)d, row "
        "%(y)d?",
        answer,
        r"With $x = %(x)d/1000$ and $y = %(y)d/1000$: $dx = %(dx).4f$ px, $dy = "
        r"%(dy).4f$ px, and $\sqrt{dx^2 + dy^2} \cdot %(g)d$ m $= %(answer)s$ m.",
        {
            "the shift at the origin is not that at the pixel": g
            * np.hypot(a[0], b[0]),
            "lengths add as squares": g * (abs(dx) + abs(dy)),
            "rows and columns are not exchanged": g
            * np.hypot(a @ (1, y / 1000, x / 1000), b @ (1, y / 1000, x / 1000)),
        },
    )


@question("7", "Circular error", "m", 1)
def ce90(draw: Chance) -> Asked:
    rmse = draw(4, 30, 0.1)
    answer = rmse * np.sqrt(np.log(10))
    return Asked(
        dict(rmse=rmse),
        r"The errors in x and y are normal, independent, equally large and zero on "
        r"average; $\mathrm{RMSE}_T = %(rmse)g$ m. How long is the CE90, which nine "
        "points in ten do not exceed?",
        answer,
        r"Beyond $k$ lie $e^{-k^2/2\sigma^2}$ of the points, with $2\sigma^2 = "
        r"\mathrm{RMSE}_T^2$. A tenth gives $k = \mathrm{RMSE}_T \sqrt{\ln 10} = 1.517 "
        r"\cdot %(rmse)g = %(answer)s$ m.",
        {
            "CE90 is longer than the RMSE": rmse / np.sqrt(np.log(10)),
            "RMSE_T has both coordinates already": rmse * np.sqrt(2 * np.log(10)),
            "1.645 belongs to one coordinate": 1.645 * rmse,
        },
    )


@question("7", "What whole pixels cost", "m", 2)
def whole_pixels(draw: Chance) -> Asked:
    dx, dy = draw(0.55, 3.45, 0.05), draw(-3.45, -0.55, 0.05)
    g = draw.of([6, 10, 15, 30])
    off = np.array([dx - round(dx), dy - round(dy)])
    answer = g * np.hypot(*off)
    return Asked(
        dict(dx=dx, dy=dy, g=g, x=abs(off[0]), y=abs(off[1])),
        "Two images with pixels of %(g)d m are shifted by exactly $dx = %(dx)g$ and $dy "
        "= %(dy)g$ px. Every chip reports the nearest whole pixels. How far is the "
        "reported shift from the true one?",
        answer,
        r"Rounding leaves $%(x).2f$ and $%(y).2f$ px: $\sqrt{%(x).2f^2 + %(y).2f^2} "
        r"\cdot %(g)d$ m $= %(answer)s$ m.",
        {
            "this is the length of the shift": g * np.hypot(dx, dy),
            "lengths add as squares": g * np.abs(off).sum(),
            "this is the length of the reported shift": g
            * np.hypot(round(dx), round(dy)),
        },
    )
