"""The data behind the workbook: source tables, an adjusted network, images, the ledger.

Every file lies in ``data/``; ``data/README.md`` says where it comes from and under
which licence. Files that were measured elsewhere are checked against their SHA-256
when they are loaded, so that a damaged table cannot pass for a published one.
"""

from pgm_lab.datasets.files import folder, rows
from pgm_lab.datasets.images import (
    Orthophoto,
    StereoPair,
    landsat,
    landsat_pair,
    motorcycle,
    yellowstone,
)
from pgm_lab.datasets.jaicov import Jaicov9x50, jaicov_9x50
from pgm_lab.datasets.sources import (
    EXTERIOR,
    INTERIOR,
    Bani2010,
    Harintaka2020,
    Muliawan2013,
    bani2010,
    bani2010_intersection,
    harintaka2020,
    muliawan2013,
)

__all__ = [
    "EXTERIOR",
    "INTERIOR",
    "Bani2010",
    "Harintaka2020",
    "Jaicov9x50",
    "Muliawan2013",
    "Orthophoto",
    "StereoPair",
    "bani2010",
    "bani2010_intersection",
    "folder",
    "harintaka2020",
    "jaicov_9x50",
    "landsat",
    "landsat_pair",
    "motorcycle",
    "muliawan2013",
    "rows",
    "yellowstone",
]
