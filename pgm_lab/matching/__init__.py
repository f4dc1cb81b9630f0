"""Two photos of a user, matched from one door: starts, correlation, least squares."""

from pgm_lab.io.photo import read
from pgm_lab.matching._quality import RECOMMENDED as RECOMMENDED_QUALITY
from pgm_lab.matching._quality import quality
from pgm_lab.matching.interest import pick
from pgm_lab.matching.pair import match
from pgm_lab.matching.result import STATUSES, Match

__all__ = [
    "RECOMMENDED_QUALITY",
    "STATUSES",
    "Match",
    "match",
    "pick",
    "quality",
    "read",
]
