"""Self-calibrating bundle adjustment: free networks, their precision and reliability.

`network` and `result` say what goes in and what comes out, `files` reads and writes
networks. In the order of the adjustment: `equations` sets up the observation equations,
`reduced` the normal equations without the points, `datum` stops the free motions,
`solve` iterates and propagates the errors, `refuse` names what is not determined,
`reliability` and `snooping` test what comes out. `lens` is the distortion, `dense` the
textbook's way with one large matrix.

Muliawan 2013, chapter II.10.
"""

from pgm_lab.bundle import dense, lens
from pgm_lab.bundle.datum import motions
from pgm_lab.bundle.files import read, write
from pgm_lab.bundle.network import Network
from pgm_lab.bundle.refuse import NetworkDefect
from pgm_lab.bundle.reliability import (
    Reliability,
    Significance,
    correlations,
    critical_value,
    reliability,
    significance,
)
from pgm_lab.bundle.result import Bundle, Unknown
from pgm_lab.bundle.snooping import Blunder, Snooping, snoop
from pgm_lab.bundle.solve import adjust

__all__ = [
    "Blunder",
    "Bundle",
    "Network",
    "NetworkDefect",
    "Reliability",
    "Significance",
    "Snooping",
    "Unknown",
    "adjust",
    "correlations",
    "critical_value",
    "dense",
    "lens",
    "motions",
    "read",
    "reliability",
    "significance",
    "snoop",
    "write",
]
