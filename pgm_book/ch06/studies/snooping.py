"""What data snooping takes out: of faultless networks, of one blunder, of bad control.

``python -m pgm_book.ch06.studies.snooping`` writes results/snooping.csv in a minute;
tests/ch06/test_studies.py repeats a part.

The networks are those of `precision`; a blunder is put on one image coordinate,
another one in each network, as large as its internal reliability or twice that.
"""

from dataclasses import replace

import numpy as np

from pgm_book.ch06.studies.precision import ALARM, CORNERS, measured, true_network
from pgm_book.common import study
from pgm_lab import bundle

COLUMNS = (
    *("case", "networks", "tested_percent", "first_percent", "others_removed"),
    *("most_others", "sigma0_before", "sigma0_after", "c_error_mm", "c_sd_mm"),
)
BLUNDERS = {"no blunder": 0.0, "smallest found by 80 %": 1.0, "twice that": 2.0}
CONTROL = {"control 0.1 mm wrong": 0.1, "control 1 mm wrong": 1.0}


def blunder(case: str, networks: int = 200) -> tuple:
    """Row of a blunder in the images.

    How often the coordinate itself has |w| above the limit, which is what the theory
    predicts; how often its ray is the first to go; how many others go.
    """
    truth = true_network()
    limits = bundle.reliability(bundle.adjust(truth, sigma0_prior=1.0)).internal
    rng = np.random.default_rng(68)
    size = BLUNDERS[case]
    found = []
    for net in measured(truth, networks, 2):
        ray, axis = rng.integers(len(net.xy)), rng.integers(2)
        xy = net.xy.copy()
        xy[ray, axis] += size * limits[ray, axis]
        snooped = bundle.snoop(replace(net, xy=xy), sigma0_prior=1.0)
        rays = [one.ray for one in snooped.removed]
        tested = abs(snooped.before.standardized[ray, axis]) > ALARM
        first = len(rays) > 0 and rays[0] == ray
        others = sum(one != ray for one in rays) if size else len(rays)
        found.append((tested, first, others, *outcome(snooped, truth)))
    return row(case, found, size > 0)


def control(case: str, networks: int = 20) -> tuple:
    """Row of one of four fixed control points that is wrong; at most 20 rays go."""
    truth = true_network()
    rng = np.random.default_rng(69)
    found = []
    for net in measured(truth, networks, 3):
        given = truth.points[CORNERS].copy()
        direction = rng.normal(size=3)
        given[0] += CONTROL[case] * direction / np.linalg.norm(direction)
        held = replace(net, control=(CORNERS, given, 0.0))
        snooped = bundle.snoop(held, sigma0_prior=1.0)
        found.append((False, False, len(snooped.removed), *outcome(snooped, truth)))
    return row(case, found, False)


def outcome(snooped: bundle.Snooping, truth: bundle.Network) -> tuple[float, ...]:
    """sigma0 before and after, error and sd of c."""
    after = snooped.result
    off = after.cameras[0].c - truth.cameras[0].c
    return snooped.before.sigma0, after.sigma0, off, after.sd_interior[0]


def row(case: str, found: list[tuple], planted: bool) -> tuple:
    """Shares and means, sigma0 and c as root mean squares."""
    tested, first, others, *numbers = np.array(found, float).T
    rms = [np.sqrt(np.mean(values**2)) for values in numbers]
    shares = (f"{100 * tested.mean():.1f}", f"{100 * first.mean():.1f}")
    return (
        *(case, len(found), *(shares if planted else ("", ""))),
        *(f"{others.mean():.2f}", int(others.max()), *(f"{v:.3g}" for v in rms)),
    )


if __name__ == "__main__":
    rows = [blunder(case) for case in BLUNDERS] + [control(case) for case in CONTROL]
    study.write("ch06", "snooping", COLUMNS, rows)
