"""Time and memory of the bundle adjustment as the network grows, beside pycolmap.

``python -m pgm_book.ch06.studies.size`` writes results/size.csv in some minutes; it
needs pycolmap. tests/ch06/test_size.py repeats a part. The table is the smaller of two
runs of it, with pycolmap 4.2.1, on a machine of two cores that had other work, too.

Seconds of the processor in one thread, all covariances included, the smallest of some
runs. Networks, start values and the two settings of pycolmap are those of
test_bundle.py, which also proves that the results agree. The memory is the most that
our adjustment holds at once, the network itself not counted.
"""

import multiprocessing
import os
import time
import tracemalloc
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor

from pgm_book.ch06.studies.network import ESTIMATE, network
from pgm_book.common import study
from pgm_lab import bundle

COLUMNS = (
    *("photos", "points", "rays", "iterations", "seconds", "peak_mb"),
    *("colmap_gauss_newton_s", "colmap_gauss_newton_iterations"),
    *("colmap_default_s", "colmap_default_iterations"),
)
# photos, points, rays of a point, block, runs
SIZES = (
    (9, 50, None, False, 200),
    (20, 300, 6, False, 80),
    (50, 2000, 8, False, 5),
    (30, 8000, 3.4, True, 3),
    (60, 26_000, 3.4, True, 3),
    (100, 60_000, 3.4, True, 2),
)


def ours(photos, points, rays, block, runs) -> tuple:
    """Rays, iterations, seconds and megabytes of our adjustment."""
    net = network(photos, points, rays, block)
    seconds = []
    for _ in range(runs):
        start = time.process_time()
        found = bundle.adjust(net, ESTIMATE)
        seconds.append(time.process_time() - start)
    assert found.status == "converged"
    tracemalloc.start()
    bundle.adjust(net, ESTIMATE)
    peak = tracemalloc.get_traced_memory()[1] / 1e6
    tracemalloc.stop()
    return len(net.xy), found.iterations, f"{min(seconds):.3g}", f"{peak:.3g}"


def theirs(photos, points, rays, block, runs, gauss_newton) -> tuple:
    """Seconds and iterations of pycolmap."""
    from pgm_book.ch06.studies import colmap

    net = network(photos, points, rays, block)
    seconds = []
    for _ in range(runs):
        reconstruction = colmap.reconstruction(net)
        start = time.process_time()
        _, summary, _ = colmap.adjust(reconstruction, gauss_newton)
        seconds.append(time.process_time() - start)
    steps = summary.num_successful_steps + summary.num_unsuccessful_steps
    assert summary.termination_type.name == "CONVERGENCE"
    return f"{min(seconds):.3g}", steps


def alone(function, *arguments):
    """Call it in a process of its own, in one thread."""
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        return pool.submit(function, *arguments).result()


def rows() -> Iterator[tuple]:
    """Rows of the table, each program alone in a process."""
    os.environ["OMP_NUM_THREADS"] = "1"  # for the processes to come
    for *size, runs in SIZES:
        row = alone(ours, *size, runs)
        for gauss_newton, times in ((True, runs), (False, max(1, runs // 2))):
            row += alone(theirs, *size, times, gauss_newton)
        print(*size, *row)
        yield (*size[:2], *row)


if __name__ == "__main__":
    study.write("ch06", "size", COLUMNS, list(rows()))
