"""Match two of your own photos with one call: starts, correlation, least squares."""

from pgm_lab._statuses import STATUSES
from pgm_lab.io.photo import read
from pgm_lab.matching._quality import RECOMMENDED as RECOMMENDED_QUALITY
from pgm_lab.matching._quality import quality
from pgm_lab.matching.interest import pick
from pgm_lab.matching.pair import Match, match

__all__ = [
    "RECOMMENDED_QUALITY",
    "STATUSES",
    "Match",
    "match",
    "pick",
    "quality",
    "read",
]
