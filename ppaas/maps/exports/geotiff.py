"""Grids as GeoTIFF, with the georeference of the map."""

import math

import numpy as np

from ppaas.distribution import install_hint
from ppaas.errors import InvalidInput
from ppaas.maps.georeference import GeoAnchor
from ppaas.maps.grid import UNKNOWN, GridMap

NO_DATA = 255
"""Value of unknown cells; others are occupancies from 0 to 100."""


def geotiff_file(grid: GridMap, anchor: GeoAnchor | None) -> bytes:
    """Return a grid as GeoTIFF.

    Its coordinates are metres to the east and north of the map's origin: a transverse Mercator projection around the
    anchor, which is the plane of the map to some millimetres in 10 km. Without an anchor they are those of the map.

    Parameters
    ----------
    grid : GridMap
    anchor : GeoAnchor, optional

    Raises
    ------
    InvalidInput
        rasterio is not installed.
    """
    try:
        import rasterio  # noqa: PLC0415 - needed for this format alone
    except ImportError as error:
        raise InvalidInput(f"GeoTIFF needs rasterio: {install_hint('gis')}") from error
    info, turn = grid.info, 0.0
    system = None
    if anchor is not None:
        turn = anchor.yaw
        system = rasterio.crs.CRS.from_proj4(
            f"+proj=tmerc +lat_0={anchor.latitude!r} +lon_0={anchor.longitude!r} +k=1 +datum=WGS84"
        )
    c, s = math.cos(turn), math.sin(turn)
    x, y = c * info.origin.x - s * info.origin.y, s * info.origin.x + c * info.origin.y
    c, s = (info.resolution * part(turn + info.origin.theta) for part in (math.cos, math.sin))
    # Rows go down from the upper left corner.
    affine = rasterio.Affine(c, s, x - s * info.height, s, -c, y + c * info.height)
    values = np.where(grid.data == UNKNOWN, NO_DATA, grid.data).astype(np.uint8)[::-1]
    profile = {
        "driver": "GTiff", "width": info.width, "height": info.height, "count": 1, "dtype": "uint8", "nodata": NO_DATA,
        "compress": "deflate", "transform": affine, "crs": system,
    }  # fmt: skip
    with rasterio.MemoryFile() as memory:
        with memory.open(**profile) as file:
            file.write(values, 1)
        return bytes(memory.read())
