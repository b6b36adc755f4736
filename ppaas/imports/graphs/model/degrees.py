"""Degrees: longitudes and latitudes, and other coordinates of the earth, in metres around an anchor."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.distribution import install_hint
from ppaas.errors import InvalidInput, Unavailable
from ppaas.imports.graphs.model.route_graph import Place
from ppaas.maps.georeference import GeoAnchor

WGS84 = "EPSG:4326"

SMALL = 0.002
"""Typical length of edges below which their coordinates are degrees, not metres: nobody draws edges of 2 mm."""


def are_degrees(places: Sequence[Place], lengths: Sequence[float]) -> bool:
    """Return whether places are longitudes and latitudes, judged by the lengths of the lines between them."""
    if not lengths or not places:
        return False
    low, high = np.min(places, axis=0), np.max(places, axis=0)
    return bool(
        np.median(lengths) < SMALL and low[0] >= -180.0 and high[0] <= 180.0 and low[1] >= -90.0 and high[1] <= 90.0
    )


def metres_around(degrees: Sequence[Place], anchor: tuple[float, float] | None, what: str) -> list[Place]:
    """Return longitudes and latitudes as x to the east and y to the north of an anchor [m].

    Parameters
    ----------
    degrees : sequence of Place
        Longitude and latitude [°].
    anchor : tuple of float, optional
        Latitude and longitude of x = 0, y = 0 [°].
    what : str
        What has the degrees, for people.

    Raises
    ------
    InvalidInput
        There is no anchor, or it is not on the Earth.
    """
    if anchor is None:
        raise InvalidInput(
            f"the positions of {what} are longitudes and latitudes: give those of x = 0, y = 0 of the map with "
            "--anchor LATITUDE LONGITUDE"
        )
    plane = GeoAnchor(*anchor)
    return [plane.to_map(latitude, longitude) for longitude, latitude in degrees]


def transformed(places: Sequence[Place], source: str, target: str) -> list[Place]:
    """Return places of one coordinate system in another: x (or longitude) first in both.

    Raises
    ------
    InvalidInput
        A coordinate system is not known.
    Unavailable
        The library is not installed.
    """
    pyproj: Any
    try:
        import pyproj  # noqa: PLC0415 - only files in degrees need it
    except ImportError as error:
        raise Unavailable(f"coordinates of the earth need pyproj: {install_hint('graphs')}") from error
    try:
        transformer = pyproj.Transformer.from_crs(source, target, always_xy=True)
    except pyproj.exceptions.CRSError as error:
        raise InvalidInput(f"unknown coordinate system: {error!s:.200}") from error
    given: NDArray[np.float64] = np.array(places, float).reshape(-1, 2)
    x, y = transformer.transform(given[:, 0], given[:, 1])
    return [(float(one), float(other)) for one, other in zip(x, y, strict=True)]
