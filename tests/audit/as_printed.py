"""Formulas of the sources exactly as they are printed, right or wrong.

The proofs compare them with derivatives and with the camera model. Nothing here is for
use in a computation."""

import csv
from pathlib import Path

import numpy as np

from pgm_book.ch05 import printed_equations as as_printed
from pgm_lab import rotation

ROW_X = ("b11", "b12", "b13", "b14", "b15", "b16")
ROW_Y = ("b21", "b22", "b23", "b24", "b25", "b26")


def terms(exterior, point):
    """M and its angles, the differences of (2.20) and r, s, q of (2.25) to (2.27)."""
    *station, omega, phi, kappa = exterior
    m = rotation.matrix(omega, phi, kappa)
    dX, dY, dZ = np.asarray(point) - station
    r, s, q = m @ (dX, dY, dZ)
    return m, (omega, phi, kappa), (dX, dY, dZ), (r, s, q)


def muliawan_2_24(f, exterior, point):
    """Coefficients b11 to b26 of Muliawan 2013, (2.24), as chapter 5 shows them.

    They multiply d omega, d phi, d kappa, dX, dY, dZ of the object point; those of the
    station are -b14 ... -b26. Returned as {name: value}.
    """
    printed = as_printed.coefficients(f, exterior, point)
    return dict(zip(ROW_X + ROW_Y, printed.ravel(), strict=True))


def muliawan_listing(f, exterior, point):
    """The same coefficients as the listings of Muliawan 2013 compute them.

    `collinier_resection` and `collinier_intersection` differ from (2.24) in b13, b22,
    b23 and b26 only.
    """
    m, (omega, phi, kappa), (dX, dY, dZ), (r, s, q) = terms(exterior, point)
    sin, cos = np.sin, np.cos
    common = cos(phi) * dX + sin(omega) * sin(phi) * dY - cos(omega) * sin(phi) * dZ
    turned = (
        sin(phi) * sin(kappa) * dX
        - sin(omega) * cos(phi) * sin(kappa) * dY
        + cos(omega) * cos(phi) * sin(kappa) * dZ
    )
    return muliawan_2_24(f, exterior, point) | {
        "b13": -f / q * (m[1, 0] * dX + m[1, 1] * dY + m[1, 2] * dZ),
        "b22": f / q**2 * (s * common - q * turned),
        "b23": f / q * (m[0, 0] * dX + m[0, 1] * dY + m[0, 2] * dZ),
        "b26": f / q**2 * (s * m[2, 2] - q * m[1, 2]),
    }


def bani_4_and_5(f, exterior, point):
    """(q, r, s) of Bani 2010, appendix B (4), and the six coefficients of (5).

    The last coefficient carries the name b24 there, for the second time; here it is
    b26, by its place.
    """
    m, _, _, (r, s, q) = terms(exterior, point)
    (m11, m12, m13), (m21, m22, m23), (m31, m32, m33) = m
    coefficients = {
        "b14": f / q**2 * (r * m31 - q * m11),
        "b15": f / q**2 * (r * m32 - q * m12),
        "b16": f / q**2 * (r * m33 - q * m13),
        "b24": f / q**2 * (s * m31 - q * m21),
        "b25": f / q**2 * (s * m32 - q * m22),
        "b26": f / q**2 * (s * m33 - q * m23),
    }
    return (q, r, s), coefficients


def brahmantara_2015():
    """Sentences of Brahmantara 2015 word for word, by their place in the paper."""
    path = Path(__file__).with_name("brahmantara2015_printed.csv")
    with path.open(encoding="utf-8", newline="") as file:
        return {row["place"]: row["text"] for row in csv.DictReader(file)}
