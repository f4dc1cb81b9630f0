"""A small image on the map, in memory and as a GeoTIFF that rasterio alone wrote."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from pgm_lab.io.geotiff import Raster

GREY = np.arange(1, 601, dtype=np.uint16).reshape(20, 30)
NOWHERE = np.zeros(GREY.shape, bool)
UTM = np.array([[6.0, 0, 700_000], [0, -6, 9_320_000]])


def on_map(**more):
    return replace(Raster(GREY, NOWHERE, UTM, "EPSG:32748"), **more)


def saved(path, grey=GREY, transform=UTM, crs="EPSG:32748", **more):
    """Write a file by rasterio alone, and return its path."""
    rasterio = pytest.importorskip("rasterio")
    bands = grey if grey.ndim == 3 else grey[None]
    tags, mask, names = (more.pop(name, None) for name in ("tags", "mask", "names"))
    if transform is not None:
        more |= {"transform": rasterio.Affine(*np.ravel(transform)), "crs": crs}
    profile = dict(driver="GTiff", count=len(bands), dtype=bands.dtype, **more)
    rows, columns = bands.shape[1:]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of a file without georeference
        file = rasterio.open(path, "w", height=rows, width=columns, **profile)
    with file:
        if tags:
            file.update_tags(**tags)
        file.write(bands)
        if names:
            file.descriptions = names
        if mask is not None:
            file.write_mask(~mask)
    return path
