"""How good surface and terrain are, in the open, under trees and on buildings.

``python -m pgm_book.ch08.studies.terrain`` writes results/terrain.csv
within some minutes; tests/ch08/test_terrain_study.py repeats a part.

A pair of `simulate.aerial_pair` is matched, gridded and filtered, and each height is
compared with the truth of its cell, by zone of the landscape and by what stands there.
Four products: the surface against the true surface, and against the true ground our
terrain, the terrain of a plain grey opening (a square of 40 m, one of 20 m) of the same
surface, and our terrain of the true surface, which has no noise of matching.

`part` is the size of what is simulated of both photos; the test repeats the small one.
`cells` is the number of cells asked for, `completeness` the share of them with a
height; errors are in m. `predicted` is the root mean square of sigma_Z of the matched
points that lie there.
"""

from collections.abc import Iterator

import cv2
import numpy as np

from pgm_book.common import study
from pgm_lab import simulate, stereo
from pgm_lab.simulate.landscape import BUILDING, OPEN, TREE, ZONES

PART, SAMPLE = (1800, 1300), (300, 220)  # pixels
CELL = 0.5  # m
KINDS = {
    "open": OPEN,
    "building": BUILDING,
    "tree": TREE,
}
NEAR = 2.0  # m: open ground nearer to an object is smeared by the windows
COLUMNS = (
    *("part", "product", "zone", "kind", "cells", "completeness"),
    *("mean", "rmse", "nmad", "le95", "predicted"),
)


def opening(surface: stereo.Surface, widest: float) -> np.ndarray:
    """Plain grey opening in a square, the gaps taken for high."""
    z = np.where(np.isnan(surface.z), np.nanmax(surface.z), surface.z)
    side = 2 * round(widest / 2 / surface.cell) + 1
    return cv2.morphologyEx(z, cv2.MORPH_OPEN, np.ones((side, side), np.uint8))


def rows(part: tuple[int, int] = PART, seed: int = 8) -> Iterator[tuple]:
    """Rows of the table for a part of the photos."""
    scene = simulate.aerial_pair(part, seed=seed)
    land = scene.landscape
    low, high = float(land.dtm.min()), float(land.dsm.max())
    pair = stereo.epipolar_pair(scene.left, scene.right, (low, high))
    points = stereo.intersect(pair, stereo.match_dense(pair, method="ncc"))
    surface = stereo.surface(points.xyz, CELL, largest_gap=np.inf)
    X, Y = surface.grid()
    dtm, dsm = land.at(land.dtm, X, Y), land.at(land.dsm, X, Y)
    true = stereo.Surface(
        np.where(np.isnan(surface.z), np.nan, dsm),
        *(surface.corner, CELL, np.isfinite(surface.z)),
    )
    products = {
        "surface": (surface.z, dsm),
        "surface, measured cells": (np.where(surface.measured, surface.z, np.nan), dsm),
        "terrain": (stereo.filter_terrain(surface).z, dtm),
        "opening 40 m": (opening(surface, 40.0), dtm),
        "opening 20 m": (opening(surface, 20.0), dtm),
        "terrain of the true surface": (stereo.filter_terrain(true).z, dtm),
    }
    shown = np.isfinite(surface.z) | (surface.source == 3)
    places = _places(land, X, Y)
    of_points = _places(land, *points.xyz[:, :2].T)
    for name, (z, truth) in products.items():
        for (zone, kind), where in places.items():
            if (where & shown).sum() < 100:
                continue
            found = stereo.quality(z, truth, where & shown)
            sd = points.sd[of_points[zone, kind], 2]
            predicted = np.sqrt(np.mean(sd**2)) if len(sd) else np.nan
            yield (
                "x".join(map(str, part)),
                *(name, zone, kind, int((where & shown).sum())),
                *(f"{found.completeness:.4f}", f"{found.mean:.4f}"),
                *(f"{v:.4f}" for v in (found.rmse, found.nmad, found.le95, predicted)),
            )


def _places(land, X, Y) -> dict[tuple[str, str], np.ndarray]:  # type: ignore[no-untyped-def]
    """Which places lie in which zone and are of which kind."""
    kind = land.at(land.kind, X, Y, cv2.INTER_NEAREST)
    n = 2 * round(NEAR / land.cell) + 1
    wide = cv2.dilate((land.kind > 0).astype(np.uint8), np.ones((n, n), np.uint8))
    clear = land.at(wide, X, Y, cv2.INTER_NEAREST) == 0
    of_kind = {name: kind == number for name, number in KINDS.items()}
    of_kind["open, 2 m from objects"] = clear
    zones = {name: land.zone(X) == k for k, name in enumerate(ZONES)}
    zones["all"] = np.ones(kind.shape, bool)
    return {(z, k): zones[z] & of_kind[k] for z in zones for k in of_kind}


if __name__ == "__main__":
    both = (row for part in (SAMPLE, PART) for row in rows(part))
    study.write("ch08", "terrain", COLUMNS, both)
