"""Counts of different people per hour and zone."""

import math
from collections.abc import Mapping

import numpy as np

from ppaas.messages.people_coordination import ZoneCount
from ppaas.people.settings import PeopleSettings
from ppaas.polygons import within_polygon

HOUR = 3600
WHOLE_MAP = ""


class ZoneCounts:
    """Numbers of different people in each zone and hour. Ids are kept for the current hour alone.

    Parameters
    ----------
    settings : PeopleSettings
        Without history, nothing is counted and what was counted is forgotten.
    """

    def __init__(self, settings: PeopleSettings) -> None:
        self.counted: dict[tuple[str, int], int] = {}
        self.hour = 0
        self.seen: dict[str, set[int]] = {}
        self.configure(settings)

    def configure(self, settings: PeopleSettings) -> None:
        """Replace the settings; counts of zones that are still there are kept."""
        self._settings = settings
        self._zones = [(zone.name, np.array(zone.corners)) for zone in settings.zones]
        if not settings.history:
            self.counted.clear()
            self.seen.clear()

    def add(self, people: Mapping[int, tuple[float, float]], now: float) -> None:
        """Count people at their positions [m], by their ids, at a time [s since the epoch]."""
        if not self._settings.history:
            return
        self._turn(now)
        if not people:
            return
        ids, points = list(people), np.array(list(people.values()))
        self.seen.setdefault(WHOLE_MAP, set()).update(ids)
        for name, corners in self._zones:
            inside = within_polygon(corners, points)
            if inside.any():
                self.seen.setdefault(name, set()).update(each for each, is_in in zip(ids, inside, strict=True) if is_in)

    def merge(self, kept: int, dropped: int) -> None:
        """Count two ids that turned out to be one person once."""
        for seen in self.seen.values():
            if dropped in seen:
                seen.discard(dropped)
                seen.add(kept)

    def since(self, earliest: int) -> list[ZoneCount]:
        """Return the counts of the hours that ended after a time [s since the epoch], by hour and zone."""
        counts = dict(self.counted)
        counts |= {(zone, self.hour): self._total(zone, self.hour) for zone in self.seen}
        return [
            ZoneCount(zone, hour, people)
            for (zone, hour), people in sorted(counts.items(), key=lambda item: (item[0][1], item[0][0]))
            if hour + HOUR > earliest
        ]

    def _total(self, zone: str, hour: int) -> int:
        return self.counted.get((zone, hour), 0) + len(self.seen.get(zone, ()))

    def _turn(self, now: float) -> None:
        """Begin a new hour if it is time, and forget counts that are older than their retention."""
        hour = math.floor(now / HOUR) * HOUR
        if hour == self.hour:
            return
        for zone in self.seen:
            self.counted[zone, self.hour] = self._total(zone, self.hour)
        self.seen, self.hour = {}, hour
        oldest = now - HOUR * self._settings.retention_hours
        self.counted = {key: count for key, count in self.counted.items() if key[1] + HOUR > oldest}
