"""Georeference of a map: where its frame is on the Earth.

It is the key ``georeference`` of the map's YAML, ``[latitude, longitude, yaw]``, which map_server and Nav2 ignore: the
WGS84 latitude and longitude of the map's frame (its point 0, 0, not the corner of its image) in degrees, and the angle
from east to its x axis in radians, counter-clockwise.
"""

import math
from dataclasses import dataclass

from ppaas.errors import InvalidMap
from ppaas.maps.yaml_keys import read_keys

KEY = "georeference"
"""Key of a map's YAML."""

EQUATOR = 6_378_137.0
"""Semi-major axis of the ellipsoid of WGS84 [m]."""

FLATTENING = 1.0 / 298.257223563
"""Flattening of the ellipsoid of WGS84."""

_SQUARED = FLATTENING * (2.0 - FLATTENING)
_POLE = EQUATOR * (1.0 - FLATTENING)
_Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class GeoAnchor:
    """Position and direction of a map's frame on the ellipsoid of WGS84.

    The map is the plane that touches the ellipsoid there, and a point of the Earth is where its vertical projection on
    that plane is. Heights above the ellipsoid are taken as 0: distances are too short by 16 ppm at 100 m.

    Parameters
    ----------
    latitude, longitude : float
        Of the point (0, 0) of the map [°].
    yaw : float
        Angle from east to the map's x axis, counter-clockwise [rad].

    Raises
    ------
    InvalidMap
        A number is not finite, the latitude is not between −90 and 90, or the longitude not from −180 to 180.
    """

    latitude: float
    longitude: float
    yaw: float = 0.0

    def __post_init__(self) -> None:
        if not math.isfinite(self.yaw):
            raise InvalidMap(f"the yaw of a georeference must be finite, not {self.yaw}")
        if not (abs(self.latitude) < 90.0 and abs(self.longitude) <= 180.0):
            raise InvalidMap(
                "a georeference needs a latitude between -90 and 90 and a longitude from -180 to 180, not "
                f"{self.latitude}, {self.longitude}"
            )

    def to_map(self, latitude: float, longitude: float) -> tuple[float, float]:
        """Return x, y [m] in the map's frame of a point of the Earth [°]."""
        place, origin = _geocentric(latitude, longitude), _geocentric(self.latitude, self.longitude)
        apart = (place[0] - origin[0], place[1] - origin[1], place[2] - origin[2])
        east, north, _ = self._axes()
        along, across = _dot(apart, east), _dot(apart, north)
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        return c * along + s * across, c * across - s * along

    def to_earth(self, x: float, y: float) -> tuple[float, float]:
        """Return latitude and longitude [°] of a point of the map's frame [m].

        Raises
        ------
        InvalidMap
            The point is so far that no point of the Earth is below or above it.
        """
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        along, across = c * x - s * y, s * x + c * y
        east, north, up = self._axes()
        origin = _geocentric(self.latitude, self.longitude)
        start = (
            origin[0] + along * east[0] + across * north[0],
            origin[1] + along * east[1] + across * north[1],
            origin[2] + along * east[2] + across * north[2],
        )
        height = _height_of_surface(start, up)
        place = (start[0] + height * up[0], start[1] + height * up[1], start[2] + height * up[2])
        latitude = math.atan2(place[2], (1.0 - _SQUARED) * math.hypot(place[0], place[1]))
        return math.degrees(latitude), math.degrees(math.atan2(place[1], place[0]))

    def moved(self, x: float, y: float, turn: float = 0.0) -> "GeoAnchor":
        """Return the anchor of a frame whose origin is at x, y [m] of this one, turned by an angle [rad]."""
        latitude, longitude = self.to_earth(x, y)
        # Meridians are not parallel: east there is not east here.
        ahead = self.to_earth(x + math.cos(self.yaw), y - math.sin(self.yaw))
        east = GeoAnchor(latitude, longitude).to_map(*ahead)
        return GeoAnchor(latitude, longitude, math.remainder(self.yaw + turn + math.atan2(east[1], east[0]), math.tau))

    def _axes(self) -> tuple[_Vector, _Vector, _Vector]:
        """Return the directions east, north and up, in geocentric coordinates."""
        latitude, longitude = math.radians(self.latitude), math.radians(self.longitude)
        c, s = math.cos(latitude), math.sin(latitude)
        x, y = math.cos(longitude), math.sin(longitude)
        return (-y, x, 0.0), (-s * x, -s * y, c), (c * x, c * y, s)


def anchor_of(record: bytes) -> GeoAnchor | None:
    """Return the georeference in the YAML of a map; None if it has none.

    Raises
    ------
    InvalidMap
        It is not a list of latitude, longitude [°] and yaw [rad], or the record is not YAML.
    """
    keys = read_keys(record) or {}
    if KEY not in keys:
        return None
    value = keys[KEY]
    numbers = [each for each in value if isinstance(each, str)] if isinstance(value, list) else []
    try:
        latitude, longitude, yaw = map(float, numbers)
    except ValueError as error:
        raise InvalidMap(
            f"the map's YAML has an invalid {KEY!r}: it must be a list of latitude, longitude [°] and yaw [rad]"
        ) from error
    return GeoAnchor(latitude, longitude, yaw)


def with_anchor(record: bytes, anchor: GeoAnchor) -> bytes:
    """Return the YAML of a map that has no georeference, with one; nothing else changes."""
    end = b"" if record.endswith(b"\n") else b"\n"
    numbers = f"{anchor.latitude!r}, {anchor.longitude!r}, {anchor.yaw!r}"
    return b"%s%s%s: [%s]\n" % (record, end, KEY.encode(), numbers.encode())


def _geocentric(latitude: float, longitude: float) -> _Vector:
    """Return x, y, z [m] of a point on the ellipsoid, from the centre of the Earth."""
    phi, lam = math.radians(latitude), math.radians(longitude)
    radius = EQUATOR / math.sqrt(1.0 - _SQUARED * math.sin(phi) ** 2)
    return (
        radius * math.cos(phi) * math.cos(lam),
        radius * math.cos(phi) * math.sin(lam),
        (1.0 - _SQUARED) * radius * math.sin(phi),
    )


def _height_of_surface(start: _Vector, up: _Vector) -> float:
    """Return how far along ``up`` the surface of the ellipsoid is from a point near it [m]."""
    scaled = (start[0] / EQUATOR, start[1] / EQUATOR, start[2] / _POLE)
    towards = (up[0] / EQUATOR, up[1] / EQUATOR, up[2] / _POLE)
    squared, half = _dot(towards, towards), _dot(scaled, towards)
    root = half * half - squared * (_dot(scaled, scaled) - 1.0)
    if not root >= 0.0:
        raise InvalidMap("the point is too far from the map's origin to be on the Earth")
    # The root of the nearer surface, in the form that does not lose digits.
    return -(_dot(scaled, scaled) - 1.0) / (half + math.sqrt(root))


def _dot(a: _Vector, b: _Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
