"""Counting of people: stores the hourly counts of coordinators, and removes the expired ones."""

import logging
from collections.abc import Callable

from starlette.concurrency import run_in_threadpool

from endpoints.people.retention import forget_all_expired, oldest_hour
from endpoints.resources.services import Services
from engine.processes.background import repeat
from ppaas.clock import epoch
from ppaas.errors import PPaaSError
from ppaas.messages.people_coordination import ZoneCount
from ppaas.people.settings import PeopleSettings
from storage.people import HOUR, PeopleCount

logger = logging.getLogger(__name__)

PERIOD = 15.0
"""Time between two collections of counts [s]; what is counted meanwhile is in the coordinator's checkpoint."""

EXPIRY_PERIOD = float(HOUR)
"""Time between two removals of expired counts [s]."""

Key = tuple[str, str]
"""User and map."""


class PeopleCounting:
    """Collects the counts of all groups whose settings have ``history``.

    A coordinator reports the counts of an hour as totals, so that a count that is collected twice counts once. After a
    restart of this process, all that coordinators still know is collected again.

    Parameters
    ----------
    services : Services
    clock : callable
        Returns the time [s since the epoch].
    """

    def __init__(self, services: Services, clock: Callable[[], float] = epoch) -> None:
        self._services = services
        self._clock = clock
        self._collected: dict[Key, float] = {}
        self._errors: dict[Key, str] = {}
        self._expiry = float("-inf")

    async def run(self) -> None:
        """Collect counts until cancelled."""
        await repeat(self.step, PERIOD)

    async def step(self) -> None:
        """Collect the counts of all groups, and remove expired ones once an hour."""
        now = self._clock()
        groups = await self._services.cloud.people.views()
        ready = {(group.user, group.map) for group in groups if group.state == "ready"}
        for notes in (self._collected, self._errors):
            for key in notes.keys() - ready:
                del notes[key]
        for key in sorted(ready):
            await self._collect(key, now)
        if now - self._expiry >= EXPIRY_PERIOD:
            await run_in_threadpool(forget_all_expired, self._services.store, now)
            self._expiry = now

    async def _collect(self, key: Key, now: float) -> None:
        try:
            if await collect_counts(self._services, *key, now, since=self._collected.get(key, 0.0)):
                self._collected[key] = now
            self._errors.pop(key, None)
        except PPaaSError as error:
            if self._errors.get(key) != str(error):
                self._errors[key] = str(error)
                logger.warning("the people of user %s on map %r are not counted now: %s", *key, error)


async def collect_counts(services: Services, user: str, map_id: str, now: float, *, since: float = 0.0) -> bool:
    """Store the counts of one group; return whether its settings have ``history``.

    Parameters
    ----------
    services : Services
    user, map_id : str
    now : float
        Time [s since the epoch].
    since : float
        Hours that ended before this time are left out [s since the epoch].

    Raises
    ------
    Unavailable
        The group has no coordinator, or the coordinator or the store does not answer.
    """
    people = await run_in_threadpool(services.store.map_people, user, map_id)
    settings = people.settings
    if not settings.history:
        return False
    oldest = max(oldest_hour(settings, now), people.counted_from)
    found = await services.cloud.people.counts(user, map_id, max(int(since), oldest))
    rows = [
        PeopleCount(user, map_id, one.hour, one.zone, one.people) for one in found if _counts(one, settings, oldest)
    ]
    await run_in_threadpool(services.store.add_people_counts, rows)
    return True


def _counts(found: ZoneCount, settings: PeopleSettings, oldest: int) -> bool:
    """Return whether a count is stored: it is recent, and its zone is the whole map or one of the settings."""
    zones = {"", *(zone.name for zone in settings.zones)}
    return found.hour >= oldest and found.zone in zones and found.people > 0
