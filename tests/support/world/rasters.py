"""Rasters as GIS programs write them, by GDAL."""

from typing import Any

import numpy as np
import rasterio
from numpy.typing import NDArray

UTM = "EPSG:25832"
CORNER = (691_000.0, 5_334_000.0)
"""Upper left corner, near 48.13° north, 11.57° east."""


def raster(
    values: NDArray[Any],
    *,
    driver: str = "GTiff",
    size: float = 0.5,
    crs: str | None = UTM,
    affine: Any = None,
    **profile: Any,
) -> bytes:
    """Return a file of one band, or of the first axis as bands."""
    bands = values if values.ndim == 3 else values[np.newaxis]
    if affine is None:
        affine = rasterio.Affine(size, 0.0, CORNER[0], 0.0, -size, CORNER[1])
    count, height, width = bands.shape
    with rasterio.MemoryFile() as memory:
        with memory.open(
            driver=driver,
            width=width,
            height=height,
            count=count,
            dtype=bands.dtype,
            crs=crs,
            transform=affine,
            **profile,
        ) as file:
            file.write(bands)
        return bytes(memory.read())
