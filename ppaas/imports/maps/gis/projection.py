"""Coordinate systems of the Earth, and the metres of a map in them."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ppaas.distribution import install_hint
from ppaas.errors import InvalidInput, InvalidMap
from ppaas.maps.georeference import GeoAnchor

if TYPE_CHECKING:
    from rasterio.crs import CRS

WGS84 = "EPSG:4326"

_STEP = 50.0
"""Distance over which directions are measured [m]."""


def gis_library() -> Any:
    """Return rasterio; ``InvalidInput`` if it is not installed."""
    try:
        import rasterio  # noqa: PLC0415 - needed for coordinate systems and rasters alone
    except ImportError as error:
        raise InvalidInput(f"rasters and coordinate systems need rasterio: {install_hint('gis')}") from error
    return rasterio


def parse_projection(text: str) -> "CRS":
    """Return the coordinate system that WKT, of ESRI too, or a code as ``EPSG:25832`` names.

    Raises
    ------
    InvalidMap
        PROJ does not know it.
    InvalidInput
        rasterio is not installed.
    """
    rasterio = gis_library()
    from rasterio.errors import CRSError  # noqa: PLC0415

    try:
        return rasterio.crs.CRS.from_user_input(text)
    except (CRSError, ValueError) as error:
        raise InvalidMap(f"PROJ does not know the coordinate system {text[:80]!r}") from error


def local_frame(system: "CRS", x: float, y: float) -> tuple[GeoAnchor, NDArray[np.float64]]:
    """Return the georeference of a place, with the x axis to the east, and the metres of a coordinate system there.

    Parameters
    ----------
    system : CRS
    x, y : float
        Place, in that system.

    Returns
    -------
    tuple of GeoAnchor and (2, 2) array
        Multiplied by a displacement in the coordinate system, it gives metres to the east and to the north. So the
        scale of a projection, feet, degrees and the direction of north are taken into account.

    Raises
    ------
    InvalidMap
        The place is not on the Earth.
    """
    rasterio = gis_library()
    from rasterio.warp import transform  # noqa: PLC0415

    step = _STEP / 111_000.0 if system.is_geographic else _STEP / (system.linear_units_factor[1] or 1.0)
    try:
        east, north = transform(system, WGS84, [x, x + step, x - step, x, x], [y, y, y, y + step, y - step])
        anchor = GeoAnchor(float(north[0]), float(east[0]))
    except (rasterio.errors.RasterioError, InvalidMap, ValueError) as error:
        raise InvalidMap(f"the place {x:g}, {y:g} is not on the Earth in the coordinate system of the file") from error
    seen = np.array([anchor.to_map(*place) for place in zip(north[1:], east[1:], strict=True)])
    return anchor, np.stack((seen[0] - seen[1], seen[2] - seen[3]), axis=1) / (2.0 * step)
