"""Times at which a zone is in force: hours of days of the week, and a first and a last moment."""

import math
from collections.abc import Iterable, Iterator, Sequence
from datetime import UTC, date, datetime, time, timedelta
from typing import Annotated, Literal
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError, available_timezones

import msgspec
from msgspec import Meta

from ppaas.errors import InvalidZones

Day = Literal["mon", "tue", "wed", "thu", "fri", "sat", "sun"]

DAYS: tuple[Day, ...] = ("mon", "tue", "wed", "thu", "fri", "sat", "sun")

Clock = Annotated[str, Meta(pattern=r"^([01][0-9]|2[0-3]):[0-5][0-9]\Z|^24:00\Z")]
"""Local time of day, such as 08:30; 24:00 is the midnight at the end of a day."""


class Hours(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True, rename={"begin": "from", "end": "to"}
):
    """Hours of some days, from ``begin`` until before ``end``. Fields that are left out do not limit.

    Parameters
    ----------
    days : list of str
        Days of the week on which the hours begin; all if empty.
    begin, end : str
        Local time of day, `from` and `to` in JSON. An end that is not after the begin is on the next day.
    since, until : datetime, optional
        First moment, and the moment after the last; local if it has no offset from UTC.

    Raises
    ------
    InvalidZones
        ``until`` is not after ``since``, or one of both has an offset from UTC.
    """

    days: list[Day] = []
    begin: Clock = "00:00"
    end: Clock = "24:00"
    since: datetime | None = None
    until: datetime | None = None

    def __post_init__(self) -> None:
        """Check the times."""
        if self.since is not None and self.until is not None:
            if (self.since.tzinfo is None) != (self.until.tzinfo is None):
                raise InvalidZones("'since' and 'until' must both have an offset from UTC, or none")
            if self.until <= self.since:
                raise InvalidZones("'until' must be after 'since'")

    def contain(self, moment: datetime) -> bool:
        """Return whether a moment, in local time, is within the hours."""
        # As numbers: two times of one zone are compared by the clock alone, which shows an hour twice in autumn.
        if self.since is not None and moment.timestamp() < _in(moment.tzinfo, self.since).timestamp():
            return False
        if self.until is not None and moment.timestamp() >= _in(moment.tzinfo, self.until).timestamp():
            return False
        clock, today = f"{moment:%H:%M}", moment.date()
        if self.begin < self.end:
            return self.begin <= clock < self.end and self._has(today)
        return self._has(today) if clock >= self.begin else clock < self.end and self._has(today - timedelta(days=1))

    def limits(self, around: datetime) -> Iterator[datetime]:
        """Yield the moments within two days after a moment at which the hours may begin or end, and some others.

        Those at which clocks are put forward or back are not among them.
        """
        zone = around.tzinfo
        for moment in (self.since, self.until):
            if moment is not None:
                yield _in(zone, moment)
        clocks = [time.fromisoformat(clock) for clock in {"00:00", self.begin, self.end} - {"24:00"}]
        for number in range(-1, 3):
            day = around.date() + timedelta(days=number)
            for clock in clocks:
                moment = datetime.combine(day, clock, zone)
                yield from (moment, moment.replace(fold=1))

    def _has(self, day: date) -> bool:
        return not self.days or DAYS[day.weekday()] in self.days


def _in(zone: object, moment: datetime) -> datetime:
    assert isinstance(zone, ZoneInfo)
    return moment.replace(tzinfo=zone) if moment.tzinfo is None else moment


def time_zone_of(name: str) -> ZoneInfo:
    """Return a time zone of the IANA database; ``InvalidZones`` if there is none of that name."""
    try:
        return ZoneInfo(name)
    except (ZoneInfoNotFoundError, ValueError, OSError) as error:
        meant = name.strip().lower()
        known = next((zone for zone in sorted(available_timezones()) if zone.lower() == meant), "Europe/Berlin")
        raise InvalidZones(f"there is no time zone {name!r:.80}: give a name such as {known!r}, or 'UTC'") from error


def is_in_force(times: Sequence[Hours], zone: ZoneInfo, now: float) -> bool:
    """Return whether some hours contain a time [s since the epoch]; always if there are none."""
    moment = datetime.fromtimestamp(now, UTC).astimezone(zone)
    return not times or any(hours.contain(moment) for hours in times)


def next_limit(times: Iterable[Hours], zone: ZoneInfo, now: float) -> float:
    """Return the first time after ``now`` [s since the epoch] at which some hours may begin or end; infinite if none.

    It is at most two days later; what is in force may be the same before and after it.
    """
    moment = datetime.fromtimestamp(now, UTC).astimezone(zone)
    later = (limit.timestamp() for hours in times for limit in hours.limits(moment))
    found = min((limit for limit in later if limit > now), default=float("inf"))
    return found if found == float("inf") else min(found, _shift(zone, now, found))


def _shift(zone: ZoneInfo, begin: float, end: float) -> float:
    """Return the first time between two at which the clocks are put forward or back; infinite if they are not."""
    before, low, high = _offset(zone, begin), math.floor(begin), math.ceil(end)
    if _offset(zone, high) == before:
        return float("inf")
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if _offset(zone, middle) == before else (low, middle)
    return float(high)


def _offset(zone: ZoneInfo, now: float) -> timedelta | None:
    return datetime.fromtimestamp(now, UTC).astimezone(zone).utcoffset()
