"""Settings of the people of a map: whom robots follow, and what is counted."""

import math

import msgspec

from ppaas.decoding import from_json
from ppaas.errors import InvalidInput

MOST_ZONES, MOST_CORNERS, MOST_TARGETS = 100, 100, 1_000
LONGEST_RETENTION = 24.0 * 366.0
"""Limit of the time for which counts are kept [h]."""


class CountingZone(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Area of a map in which people are counted.

    Parameters
    ----------
    name : str
    corners : list of tuple of float
        Corners of a polygon, x, y in the frame of the map [m].
    """

    name: str
    corners: list[tuple[float, float]]


class PeopleSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Settings of the robots of a user on a map.

    Parameters
    ----------
    rule : str
        Name of the rule that chooses whom to follow, an entry point of ``ppaas.people_rules``.
    targets : list of int
        Ids of the people to follow by the rule ``named``.
    followed_at_once : int
        Largest number of people who are followed at once, each by one robot.
    names : dict of str to str
        Names that users gave to people, by their ids.
    zones : list of CountingZone
    history : bool
        Whether people are counted per hour and zone. Counts are numbers only, and off by default.
    retention_hours : float
        Time for which counts are kept [h].

    Raises
    ------
    InvalidInput
        A value is out of range.
    """

    rule: str = "nearest"
    targets: list[int] = []
    followed_at_once: int = 1
    names: dict[str, str] = {}
    zones: list[CountingZone] = []
    history: bool = False
    retention_hours: float = 24.0 * 30.0

    def __post_init__(self) -> None:
        """Check the ranges."""
        if len(self.targets) > MOST_TARGETS or len(self.names) > MOST_TARGETS:
            raise InvalidInput(f"targets and names may have up to {MOST_TARGETS} entries")
        if not 0 <= self.followed_at_once <= MOST_TARGETS:
            raise InvalidInput(f"followed_at_once must be from 0 to {MOST_TARGETS}, not {self.followed_at_once}")
        if not 0.0 < self.retention_hours <= LONGEST_RETENTION:
            raise InvalidInput(f"retention_hours must be above 0 and up to {LONGEST_RETENTION:g}")
        if len(self.zones) > MOST_ZONES:
            raise InvalidInput(f"there may be up to {MOST_ZONES} zones, not {len(self.zones)}")
        for zone in self.zones:
            _check(zone)
        if len({zone.name for zone in self.zones}) != len(self.zones):
            raise InvalidInput("zones must have different names")


def _check(zone: CountingZone) -> None:
    if not 0 < len(zone.name) <= 64:
        raise InvalidInput("the name of a zone must have from 1 to 64 characters")
    if not 3 <= len(zone.corners) <= MOST_CORNERS:
        raise InvalidInput(f"zone {zone.name!r} must have from 3 to {MOST_CORNERS} corners, not {len(zone.corners)}")
    if not all(math.isfinite(number) for corner in zone.corners for number in corner):
        raise InvalidInput(f"the corners of zone {zone.name!r} must be finite")


def settings_of(text: str | bytes) -> PeopleSettings:
    """Read settings from JSON.

    Raises
    ------
    InvalidInput
        It is not valid JSON, a field is unknown, or a value is out of range.
    """
    try:
        return from_json(text, PeopleSettings)
    except msgspec.ValidationError as error:
        raise InvalidInput(f"settings of people: {error}") from error
    except msgspec.DecodeError as error:
        raise InvalidInput(f"settings of people are not valid JSON: {error}") from error
