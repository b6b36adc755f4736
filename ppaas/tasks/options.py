"""Options of a task beyond its places: waits at places, tasks that come first, and repeats by a calendar."""

import math
import re
from collections.abc import Iterator
from datetime import UTC, datetime, time, timedelta
from typing import Literal

import msgspec

from ppaas.errors import InvalidInput, InvalidZones
from ppaas.zones.schedule import DAYS, Day, time_zone_of

# -- waits at places ---------------------------------------------------------------------------------------------------

LONGEST_HOLD = 7 * 86400.0
"""Limit of the time for which a robot waits at a place [s]."""


MOST_ITEMS, MOST_OF_ITEM = 16, 1_000_000
"""Limits of the types of items that a workcell is asked for, and of the quantity of each."""


class PlaceHold(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """What a robot waits for at a place before it goes on.

    Parameters
    ----------
    confirm : bool
        It waits until somebody confirms the task.
    seconds : float, optional
        It goes on after this time [s], also without a confirmation; None for no limit.
    charge : float, optional
        It goes on once its battery has this charge, from 0 to 1.
    dispenser, ingestor : str
        Workcell of Open-RMF that confirms that it has loaded or unloaded the robot; empty for none.
    items : dict of str to int
        What the workcell is asked for: quantities by type.
    """

    confirm: bool = False
    seconds: float | None = None
    charge: float | None = None
    dispenser: str = ""
    ingestor: str = ""
    items: dict[str, int] = {}

    @property
    def is_confirmed(self) -> bool:
        """Whether it waits for somebody, or for a workcell, to confirm it."""
        return self.confirm or bool(self.dispenser or self.ingestor)


def check_hold(hold: PlaceHold) -> PlaceHold:
    """Return a hold; ``InvalidInput`` if it waits for nothing, or for no possible time."""
    if not hold.is_confirmed and hold.seconds is None and hold.charge is None:
        raise InvalidInput("a hold needs 'confirm', a time in 'seconds', a 'charge', or a 'dispenser' or 'ingestor'")
    if hold.dispenser and hold.ingestor:
        raise InvalidInput("a hold needs a 'dispenser' or an 'ingestor', and not both")
    if len(hold.items) > MOST_ITEMS or not all(0 < number <= MOST_OF_ITEM for number in hold.items.values()):
        raise InvalidInput(f"a workcell may be asked for {MOST_ITEMS} types of items, for 1 to {MOST_OF_ITEM} of each")
    if hold.charge is not None and not 0.0 < hold.charge <= 1.0:
        raise InvalidInput(f"the charge of a hold must be above 0, and 1 at most, not {hold.charge:g}")
    if hold.seconds is not None and not 0.0 < hold.seconds <= LONGEST_HOLD:
        raise InvalidInput(f"a robot may hold for up to {LONGEST_HOLD:g} s, and for more than 0, not {hold.seconds:g}")
    return hold


# -- tasks that come first ---------------------------------------------------------------------------------------------

End = Literal["done", "failed", "ended"]
"""How another task must end: ``ended`` is any end."""

MOST_BEFORE = 16
"""Limit of the tasks that a task waits for."""


class After(msgspec.Struct, frozen=True, kw_only=True):
    """Another task that must end before a task may begin.

    Parameters
    ----------
    task : str
        Id of the other task.
    on : {"done", "failed", "ended"}
        How it must end.
    """

    task: str
    on: End = "done"


# -- repeats -----------------------------------------------------------------------------------------------------------

MOST_RUNS = 1_000_000
"""Limit of the runs of a task that repeats."""

LEAST_PERIOD = 1.0
LONGEST_PERIOD = 366 * 86400.0
"""Limits of the time from the start of a run to the start of the next [s]."""

MOST_CLOCKS = 48
"""Limit of the times of a day at which a task repeats."""

_CLOCK = re.compile(r"([01][0-9]|2[0-3]):[0-5][0-9]|24:00")
_DAYS_AHEAD = 9  # a week has each day, and the clocks may skip one of its times


class Repeat(msgspec.Struct, frozen=True, kw_only=True):
    """When a task is done again: at times of a day, or after a period.

    Parameters
    ----------
    at : tuple of str
        Local times of day, such as 08:30.
    days : tuple of str
        Days of the week; all if empty.
    zone : str
        Time zone of the times, by its name in the IANA database.
    every : float, optional
        Period from start to start [s], in place of times of day.
    count : int, optional
        Number of runs, the first one included; None for no limit.
    until : float, optional
        No run starts after this time [s since the epoch].
    """

    at: tuple[str, ...] = ()
    days: tuple[Day, ...] = ()
    zone: str = "UTC"
    every: float | None = None
    count: int | None = None
    until: float | None = None


def check_repeat(repeat: Repeat) -> Repeat:
    """Return a repeat; ``InvalidInput`` if it makes no sense."""
    if bool(repeat.at) == (repeat.every is not None):
        raise InvalidInput("a repeat needs times of day in 'at', or a period in 'every', and not both")
    if repeat.every is not None and not LEAST_PERIOD <= repeat.every <= LONGEST_PERIOD:
        raise InvalidInput(f"'every' must be {LEAST_PERIOD:g} to {LONGEST_PERIOD:g} s, not {repeat.every:g}")
    if len(repeat.at) > MOST_CLOCKS:
        raise InvalidInput(f"a task may repeat at {MOST_CLOCKS} times of a day at most, not {len(repeat.at)}")
    for clock in repeat.at:
        if _CLOCK.fullmatch(clock) is None:
            raise InvalidInput(f"a time of day is written as 08:30, not {clock[:20]!r}")
    if not repeat.at and repeat.days:
        raise InvalidInput("'days' need times of day in 'at'")
    if repeat.count is not None and not 1 <= repeat.count <= MOST_RUNS:
        raise InvalidInput(f"'count' must be 1 to {MOST_RUNS}, not {repeat.count}")
    try:
        time_zone_of(repeat.zone)
    except InvalidZones as error:
        raise InvalidInput(str(error)) from error
    return repeat


def next_start(repeat: Repeat, start: float, now: float) -> float:
    """Return when the next run may start [s since the epoch]: after ``now``, so that missed runs are left out.

    Parameters
    ----------
    repeat : Repeat
    start : float
        Time at which the run before could start [s since the epoch].
    now : float
        Time [s since the epoch].
    """
    if repeat.every is not None:
        missed = max(0.0, math.ceil((now - start) / repeat.every) - 1.0)
        return start + repeat.every * (1.0 + missed)
    return min(moment for moment in _moments(repeat, max(start, now)) if moment > max(start, now))


def _moments(repeat: Repeat, after: float) -> Iterator[float]:
    """Yield the times of a repeat on the days around a time [s since the epoch]."""
    zone = time_zone_of(repeat.zone)
    today = datetime.fromtimestamp(after, UTC).astimezone(zone).date()
    for number in range(-1, _DAYS_AHEAD):
        day = today + timedelta(days=number)
        if repeat.days and DAYS[day.weekday()] not in repeat.days:
            continue
        for clock in repeat.at:
            date, begin = (day + timedelta(days=1), "00:00") if clock == "24:00" else (day, clock)
            yield datetime.combine(date, time.fromisoformat(begin), zone).timestamp()
