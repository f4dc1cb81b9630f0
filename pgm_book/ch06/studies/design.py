"""What a network must look like to tell c, x0 and y0 from the exterior orientations.

``python -m pgm_book.ch06.studies.design`` writes results/design.csv in some minutes;
tests/ch06/test_studies.py repeats a part.

A choice of photos is refused if it has a rank defect, and has not converged if
MAX_ITERATIONS steps were not enough: the data hardly determine something, and the
iteration wanders along it. Only of the converged there are numbers.

Standard deviations are for the same error of an image coordinate everywhere, that of
the real network of Muliawan 2013; only the geometry differs. Column sigma0_um alone is
what each adjustment finds itself.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np
from tqdm import tqdm

from pgm_book.ch06.studies import starts
from pgm_book.common import study
from pgm_lab import bundle, simulate
from pgm_lab.adjustment import normal

ENDINGS = ("converged", "refused", "not_converged")
COLUMNS = (
    *("network", "case", "photos", "choices", *ENDINGS),
    *("sigma0_um", "c_mm"),
    *("sd_c_um", "sd_x0_um", "sd_y0_um"),
    *("r_c_exterior", "r_x0_exterior", "r_y0_exterior"),
    *("r_interior", "interior_pair", "sd_points_mm"),
)
KEYS = COLUMNS[:3]
NUMBERS = COLUMNS[len(KEYS) + 1 + len(ENDINGS) :]
BLANK = ("",) * len(NUMBERS)
MAX_ITERATIONS = 500
# Chosen by station and by kappa, which is near 0, 90 or 180 degrees
CHOICES = {
    "all": (1, 2, 3, 4, 5, 6, 7, 8, 9),
    "one roll: kappa 90": (1, 3, 6, 7),
    "two rolls at the same stations": (2, 4, 6, 7),
    "rolls 0 and 180 only": (2, 4, 5, 8, 9),
    "two stations that converge by 15 degrees": (1, 2, 3, 4, 5),
    "one station": (3, 4, 5),
}


def chosen(net: bundle.Network, photos: Sequence[int]) -> bundle.Network:
    """The network of some photos, given by their numbers."""
    index = np.array(photos) - 1
    kept = np.isin(net.photo, index)
    return replace(
        net,
        exteriors=net.exteriors[index],
        photo=np.searchsorted(index, net.photo[kept]),
        point=net.point[kept],
        xy=net.xy[kept],
        sigma=net.sigma[kept],
        camera=net.camera[index],
        photo_names=photos,
    )


def adjusted(net: bundle.Network) -> tuple[str, bundle.Bundle | None]:
    """How the adjustment of a network ended, and the network if it converged."""
    try:
        found = bundle.adjust(net, max_iterations=MAX_ITERATIONS)
    except normal.RankDefect:
        return "refused", None
    if found.status != "converged":
        return "not_converged", None
    if not starts.in_front(found):
        raise ValueError("points lie behind their photos; take better start values")
    return "converged", found


def one(net: bundle.Network, sigma0: float) -> tuple:
    """Columns after the keys, for a single network."""
    ending, found = adjusted(net)
    numbers = BLANK if found is None else described(found, sigma0)
    return (1, *(int(ending == name) for name in ENDINGS), *numbers)


def described(found: bundle.Bundle, sigma0: float) -> tuple:
    """Numbers of an adjusted network."""
    scale = sigma0 / found.sigma0
    sd_c, *sd = 1000 * scale * found.sd_interior[:3]
    r = np.abs(found.correlation)
    u = len(found.estimate)
    # K1, K2, K3 are powers of the same radius, whatever the network is
    radial = np.array([name[0] == "K" for name in found.estimate])
    among = np.triu(r[:u, :u], 1) * ~(radial[:, None] & radial)
    pair = np.unravel_index(np.argmax(among), among.shape)
    points = scale * np.sqrt(np.mean(found.sd_points**2))
    return (
        f"{1000 * found.sigma0 * found.network.sigma[0, 0]:.3f}",
        *(f"{found.cameras[0].c:.3f}", *(f"{value:.3g}" for value in (sd_c, *sd))),
        *(f"{value:.4f}" for value in r[:3, u:].max(axis=1)),
        *(f"{among.max():.3f}", " ".join(found.names[i] for i in pair)),
        f"{points:.3g}",
    )


def real(net: bundle.Network, sigma0: float) -> list[tuple]:
    """Rows of the real network, and of photos chosen from it."""
    return [
        (
            "real",
            case,
            " ".join(map(str, photos)),
            *one(chosen(net, photos), sigma0),
        )
        for case, photos in CHOICES.items()
    ]


def subsets(net: bundle.Network, sigma0: float, size: int) -> list[tuple]:
    """How the choices of so many photos end; best, median, worst of the converged."""
    count, found = dict.fromkeys(ENDINGS, 0), []
    choices = list(combinations(range(1, 10), size))
    for photos in tqdm(choices, f"{size} photos", leave=False):
        ending, result = adjusted(chosen(net, photos))
        count[ending] += 1
        if result is not None:
            row = described(result, sigma0)
            found.append((float(row[NUMBERS.index("sd_c_um")]), photos, row))
    found.sort()
    counts = len(choices), *count.values()
    return [("real", f"{size} photos", "any", *counts, *BLANK)] + [
        (
            *("real", f"{size} photos, {title} of the converged"),
            *(" ".join(map(str, photos)), 1, 1, 0, 0, *row),
        )
        for title, (_, photos, row) in (
            ("best", found[0]),
            ("median", found[len(found) // 2]),
            ("worst", found[-1]),
        )
    ]


def simulated(cam, sigma: float) -> list[tuple]:
    """Rows of nine simulated photos: convergent or not, rolled or not, deep or flat."""
    rows = []
    for convergent in (True, False):
        for rolled in (True, False):
            for flat in (False, True):
                rng = np.random.default_rng(6)
                known = simulate.network(
                    *(cam, 9, 50, rng),
                    convergent=convergent,
                    rolled=rolled,
                    flat=flat,
                    sigma=sigma,
                    distance=1500.0,
                    image_size=(24.0, 16.0),
                )
                net = bundle.Network(
                    *(known.camera, known.exteriors, known.points),
                    *(known.photo, known.point, known.xy, sigma),
                )
                case = (
                    "convergent" if convergent else "parallel",
                    "rolled" if rolled else "upright",
                    "flat" if flat else "deep",
                )
                rows.append(("simulated", ", ".join(case), 9, *one(net, 1.0)))
    return rows


if __name__ == "__main__":
    net = starts.network()
    found = starts.solution(net)
    table = real(net, found.sigma0)
    for size in (3, 4, 5, 6):
        table += subsets(net, found.sigma0, size)
    table += simulated(found.cameras[0], found.sigma0 / 1000)
    study.write("ch06", "design", COLUMNS, table)
