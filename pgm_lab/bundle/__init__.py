"""Self-calibrating bundle adjustment: free networks, their precision and reliability.

Muliawan 2013, chapter II.10.
"""

from pgm_lab.bundle._rank import NetworkDefect
from pgm_lab.bundle._solve import adjust
from pgm_lab.bundle.network import Network
from pgm_lab.bundle.result import Bundle

__all__ = ["Bundle", "Network", "NetworkDefect", "adjust"]
