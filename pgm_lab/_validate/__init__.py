"""The door for bad input: checks of what a caller hands over.

Each names the argument and what was expected.
"""

from pgm_lab._validate._numbers import (
    MOST,
    finite,
    not_negative,
    number,
    pair,
    positive,
    positive_number,
    probability,
    real,
    shown,
    size,
    standard_deviation,
    whole,
    window,
)
from pgm_lab._validate._shapes import (
    broadcast,
    covariances,
    image,
    image_size,
    not_exchanged,
    point_list,
    points,
    refuse,
)
from pgm_lab._validate._things import (
    choice,
    flag,
    function,
    instance,
    several,
    texts,
)

__all__ = [
    "MOST",
    "broadcast",
    "choice",
    "covariances",
    "finite",
    "flag",
    "function",
    "image",
    "image_size",
    "instance",
    "not_exchanged",
    "not_negative",
    "number",
    "pair",
    "point_list",
    "points",
    "positive",
    "positive_number",
    "probability",
    "real",
    "refuse",
    "several",
    "shown",
    "size",
    "standard_deviation",
    "texts",
    "whole",
    "window",
]
