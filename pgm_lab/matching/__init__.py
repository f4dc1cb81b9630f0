"""Two photos of a user, matched from one door: starts, correlation, least squares."""

from pgm_lab.matching.result import STATUSES, Match

__all__ = ["STATUSES", "Match"]
