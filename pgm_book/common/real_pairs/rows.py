"""Rows of the table: what is matched, and how well. Each takes seconds.

The row ``curve`` also writes results/matching_quality.csv: the share of wrong matches
against the share that is kept, as the quality rises.
"""

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np

from pgm_book.common import study
from pgm_book.common.real_pairs.pairs import (
    Stereo,
    Warped,
    graffiti,
    rephotographed,
    stereo_pairs,
    subjects,
)
from pgm_lab import lsm, matching, ncc
from pgm_lab.matching import RECOMMENDED_QUALITY, quality

Row = tuple[str, str, str]  # what, pair, figures

# --- Points as a user would choose them, and the error of a match ---

MARGIN = 30  # px


def picked(image: np.ndarray, number: int, margin: int = MARGIN) -> np.ndarray:
    """Points (n, 2) of best texture in each cell, where it is at least average.

    They lie on edges of objects more often than not.
    """
    texture = cv2.cornerMinEigenVal(image.astype(np.float32), 21)
    size, least = max(6, int(np.sqrt(image.size / number))), np.median(texture)
    found = []
    rows, columns = image.shape
    for row in range(margin, rows - margin - size + 1, size):
        for column in range(margin, columns - margin - size + 1, size):
            cell = texture[row : row + size, column : column + size]
            y, x = np.unravel_index(cell.argmax(), cell.shape)
            if cell[y, x] > least:
                found.append((column + x, row + y))
    return np.array(found, float).reshape(-1, 2)


def grid(image: np.ndarray, number: int) -> np.ndarray:
    """Points (n, 2) that do not depend on the image."""
    rows, columns = image.shape
    size = int(np.sqrt(image.size / number))
    x, y = np.meshgrid(
        np.arange(MARGIN, columns - MARGIN, size),
        np.arange(MARGIN, rows - MARGIN, size),
    )
    return np.stack([x.ravel(), y.ravel()], axis=1).astype(float)


def textured(pair: Warped, number: int, margin: int = 60) -> np.ndarray:
    """Points with good texture that both photos show, well inside."""
    points = picked(pair.left, number, margin)
    truth = pair.truth(points)
    size = np.array(pair.right.shape[::-1])
    return points[np.all((truth > margin) & (truth < size - margin), axis=1)]


def smooth(pair: Stereo, number: int, template: int) -> np.ndarray:
    """Points with texture where the template sees one surface: no step of 3 px."""
    points = picked(pair.left, number)
    known = np.where(np.isnan(pair.disparity), 1e4, pair.disparity).astype(np.float32)
    window = np.ones((template, template), np.uint8)
    step = cv2.dilate(known, window) - cv2.erode(known, window)
    column, row = points.astype(int).T
    seen = ~np.isnan(pair.disparity[row, column])
    return points[seen & (step[row, column] < 3)]


def distance(found: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """Distances (n,) in pixels; NaN where nothing was found or known."""
    return np.linalg.norm(found - truth, axis=1)


def robust_sd(values: np.ndarray) -> float:
    """Standard deviation of normal values, robust against some wrong ones."""
    return float(np.median(np.abs(values - np.median(values))) / 0.6745)


# --- Real and made pairs ---


def far_starts(folder: Path) -> Iterator[Row]:
    """Windows rotated or scaled without a start for the shape, compared with ECC."""
    for degrees, scale in ((15, 1), (0, 0.85)):
        for name, subject in subjects(folder).items():
            pair = rephotographed(name, subject, degrees, scale)
            points = textured(pair, 250)[:150]
            truth = pair.truth(points)
            start = np.rint(truth)
            ours = lsm.match(pair.left, pair.right, points, start).points
            ecc = _ecc(pair, points, start)
            shares = [
                f"{np.mean(e < 0.5):.3f} right {np.mean(e > 1):.3f} wrong"
                for e in (distance(ours, truth), distance(ecc, truth))
            ]
            yield (
                f"rotated {degrees}, scale {scale}",
                f"{name} (made), {len(points)}",
                f"lsm {shares[0]}; ECC {shares[1]}",
            )


def _ecc(
    pair: Warped, points: np.ndarray, start: np.ndarray, half: int = 10, pad: int = 12
) -> np.ndarray:
    """Right points (n, 2) by cv2.findTransformECC, affine, from the same starts."""
    found = np.full(points.shape, np.nan)
    around, stop = half + pad, (3, 50, 1e-5)
    for i, ((x, y), (u, v)) in enumerate(
        zip(points.astype(int), start.astype(int), strict=True)
    ):
        template = pair.left[y - half : y + half + 1, x - half : x + half + 1]
        part = pair.right[v - around : v + around + 1, u - around : u + around + 1]
        T = np.array([[1, 0, pad], [0, 1, pad]], np.float32)
        try:
            _, T = cv2.findTransformECC(
                template, part, T, cv2.MOTION_AFFINE, stop, None, 5
            )
        except cv2.error:
            continue  # it found nothing
        found[i] = T @ [half, half, 1] + (u - around, v - around)
    return found


def precision(folder: Path) -> Iterator[Row]:
    """Errors across the rows, where the truth is zero, divided by the predicted sd."""
    for pair in stereo_pairs(folder):
        figures = []
        for template in (11, 21, 31):
            points = smooth(pair, 900, template)
            truth = pair.truth(points)
            found = lsm.match(pair.left, pair.right, points, np.rint(truth), template)
            k = distance(found.points, truth) < 2
            error = (found.points - truth)[k, 1]
            z = error / np.sqrt(found.covariance[k, 1, 1])
            figures.append(f"{template}: {robust_sd(z):.2f} ({k.sum()})")
        yield "error / predicted", pair.name, ", ".join(figures)


def rows_like_stereobm(folder: Path) -> Iterator[Row]:
    """Search along the rows with left-right check, beside OpenCV's block matching."""
    for pair in stereo_pairs(folder):
        points = grid(pair.left, 2500)
        truth = pair.truth(points)
        points, truth = (v[~np.isnan(truth[:, 0])] for v in (points, truth))
        most = pair.most + 16 - pair.most % 16
        column, row = points.astype(int).T
        for size in (9, 15):
            block = cv2.StereoBM.create(most, size).compute(pair.left, pair.right)
            d = block[row, column] / 16
            theirs = np.where(d > 0, np.abs(d - (points - truth)[:, 0]), np.nan)
            width = most + size + 1 - (most + size) % 2
            found = ncc.match(
                *(pair.left, pair.right, points, points - (most // 2, 0), size),
                *((size + 2, width), 0.7, 0.95, "parabola"),
                lines=np.stack([0 * row, 0 * row + 1, -row], axis=1),
                distance=0.5,
                back=0.75,
            )
            ours = np.where(found.accepted, distance(found.points, truth), np.nan)
            right, wrong = (
                [np.mean(e <= 1) for e in (ours, theirs)],
                [np.nanmean(e[~np.isnan(e)] > 1) for e in (ours, theirs)],
            )
            yield (
                f"rows, template {size}",
                f"{pair.name}, {len(points)}",
                f"right {right[0]:.3f}, StereoBM {right[1]:.3f}:"
                f" {right[0] / right[1]:.2f}; wrong among accepted {wrong[0]:.3f},"
                f" {wrong[1]:.3f}",
            )


def wrong_ones(folder: Path) -> Iterator[Row]:
    """Accepted and wrong by more than 1 px: ncc, then lsm, then by quality."""
    for pair in stereo_pairs(folder):
        for how, choose in (("picked", picked), ("grid", grid)):
            yield _wrong(pair, how, choose(pair.left, 1600))


def _wrong(pair: Stereo, how: str, points: np.ndarray) -> Row:
    truth = pair.truth(points)
    points, truth = (v[~np.isnan(truth[:, 0])] for v in (points, truth))
    e_ncc, e_lsm, q = errors_and_quality(pair, points, truth)
    kept = q >= RECOMMENDED_QUALITY
    return (
        f"wrong, {how}",
        f"{pair.name}, {len(points)}",
        f"ncc {np.mean(e_ncc > 1):.1%} of {len(e_ncc)}; lsm {np.mean(e_lsm > 1):.1%} of"
        f" {len(e_lsm)}; quality {np.mean(e_lsm[kept] > 1):.1%}, kept"
        f" {kept.mean():.0%}",
    )


def errors_and_quality(
    pair: Stereo, points: np.ndarray, truth: np.ndarray, template: int = 21
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Errors of what ncc accepts and of what lsm accepts of it, and its quality."""
    middle = points - (pair.most // 2, 0)
    search = template + 4, pair.most // 2 * 2 + template
    near = ncc.match(pair.left, pair.right, points, middle, template, search)
    k = near.accepted
    points, truth, start = points[k], truth[k], near.points[k]
    found = lsm.match(pair.left, pair.right, points, start, template)
    q = quality(pair.left, pair.right, points, found, template)
    k = found.accepted
    return distance(start, truth), distance(found.points, truth)[k], q[k]


def one_call(folder: Path) -> Iterator[Row]:
    """200 points by `matching.match`, photos rotated by 10 degrees, scale 1.2."""
    pairs = [rephotographed(n, s, 10, 1.2) for n, s in subjects(folder).items()]
    for pair in pairs + graffiti(folder):
        found = matching.match(pair.left, pair.right)
        error = distance(found.points, pair.truth(found.chosen))
        k = found.accepted
        kept = k & (found.quality >= RECOMMENDED_QUALITY)
        yield (
            "one call, 200 points",
            f"{pair.name}{'' if pair.name == 'graffiti' else ' (made)'}",
            f"{(error <= 1).sum()} right, {(error > 1).sum()} wrong; quality keeps"
            f" {kept.sum()}, {(error[kept] > 1).sum()} wrong",
        )


# --- Quality: kept and wrong at each limit ---

LIMITS = (0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98)
COLUMNS = ("pair", "points", "matches", "least_quality", "kept", "wrong")


def curve(folder: Path) -> Iterator[Row]:
    """Kept and wrong at each limit, for each pair with truth and both choices."""
    lines = []
    for pair in stereo_pairs(folder):
        for how, choose in (("picked", picked), ("grid", grid)):
            points = choose(pair.left, 1600)
            truth = pair.truth(points)
            known = ~np.isnan(truth[:, 0])
            _, error, q = errors_and_quality(pair, points[known], truth[known])
            shares = [
                (np.mean(q >= limit), np.mean(error[q >= limit] > 1))
                for limit in LIMITS
            ]
            lines += [
                (pair.name, how, len(q), limit, f"{kept:.3f}", f"{wrong:.4f}")
                for limit, (kept, wrong) in zip(LIMITS, shares, strict=True)
            ]
            yield (
                "curve: kept/wrong",
                f"{pair.name}, {how}",
                " ".join(f"{kept:.0%}/{wrong:.1%}" for kept, wrong in shares),
            )
    study.write("common", "matching_quality", COLUMNS, lines)


ROWS = {
    "far": far_starts,
    "precision": precision,
    "stereobm": rows_like_stereobm,
    "wrong": wrong_ones,
    "call": one_call,
    "curve": curve,
}
