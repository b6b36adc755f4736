"""Changes of the settings of people: they are stored, and the coordinator of the group goes on with them."""

from collections.abc import Callable
from contextlib import suppress

from msgspec.structs import replace
from starlette.concurrency import run_in_threadpool

from endpoints.people.retention import forget_expired
from endpoints.resources.services import Services
from ppaas.clock import epoch
from ppaas.errors import Conflict, InvalidInput, InvalidParameter, InvalidZones, NotFound, NotPermitted
from ppaas.people.rules.registry import create
from ppaas.people.settings import PeopleSettings
from ppaas.zones.validity import outline_fault
from storage.people import HOUR, MapPeople, changed_meanwhile
from storage.ports import Store

NAMED = "named"
"""Rule by which the given people are followed."""

ATTEMPTS = 8
"""Number of attempts to change settings that other clients change too."""

Change = Callable[[PeopleSettings], PeopleSettings]


async def change_settings(services: Services, user: str, map_id: str, change: Change) -> PeopleSettings:
    """Change the settings of a user on a map; return the new ones.

    Parameters
    ----------
    services : Services
    user, map_id : str
        The user may read the map.
    change : callable
        Takes the current settings; returns the new ones.

    Raises
    ------
    InvalidParameter
        No rule of that name is installed and allowed.
    InvalidZones
        The outline of a new zone crosses itself.
    InvalidInput, NotFound
        The coordinator refuses the settings; the previous ones are stored again.
    Conflict
        Other clients kept changing the settings.
    Unavailable
        The store or the coordinator does not answer. The settings may be stored already: try again.
    """
    before, after = await run_in_threadpool(_update, services.store, user, map_id, lambda people: _with(people, change))
    try:
        await _configure(services, user, map_id, after.settings)
    except (InvalidInput, NotFound):
        await run_in_threadpool(_update, services.store, user, map_id, lambda now: _put_back(now, before, after))
        raise
    await run_in_threadpool(forget_expired, services.store, after, epoch())
    return after.settings


async def forget_counts(services: Services, user: str, map_id: str) -> None:
    """Remove all counts of a user on a map, also the coordinator's.

    A coordinator that runs forgets its counts when it is configured without ``history``. One that does not has them in
    its checkpoint: what it counted in this hour and before is not collected when it runs again.

    Raises
    ------
    Unavailable
        The store or the coordinator does not answer: try again.
    """
    groups = await services.cloud.people.views()
    try:
        if any((group.user, group.map, group.state) == (user, map_id, "ready") for group in groups):
            await _let_forget(services, user, map_id)
        else:
            later = _next_hour()
            await run_in_threadpool(
                _update, services.store, user, map_id, lambda people: replace(people, counted_from=later)
            )
    finally:
        await run_in_threadpool(services.store.remove_people_counts, user, map_id)


async def _let_forget(services: Services, user: str, map_id: str) -> None:
    settings = (await run_in_threadpool(services.store.map_people, user, map_id)).settings
    if settings.history:
        await services.cloud.people.configure(user, map_id, replace(settings, history=False))
        await _configure(services, user, map_id, settings)


def follow(people: list[int]) -> Change:
    """Return the change by which robots follow these people, and nobody else."""
    return lambda settings: replace(settings, rule=NAMED, targets=people, followed_at_once=max(1, len(people)))


def _update(
    store: Store, user: str, map_id: str, change: Callable[[MapPeople], MapPeople]
) -> tuple[MapPeople, MapPeople]:
    """Change a record; return the previous one and the new one. If another was stored meanwhile, change that."""
    for _ in range(ATTEMPTS):
        before = store.map_people(user, map_id)
        after = change(before)
        with suppress(Conflict):
            store.put_people_settings(after, instead_of=before)
            return before, after
    raise changed_meanwhile(map_id)


def _next_hour() -> int:
    return (int(epoch()) // HOUR + 1) * HOUR


def _with(people: MapPeople, change: Change) -> MapPeople:
    """Return a record with changed settings.

    Raises
    ------
    InvalidParameter
        Their rule is not installed or not allowed.
    InvalidZones
        The outline of a zone that they did not have before is not valid.
    """
    settings = change(people.settings)
    for zone in settings.zones:
        if zone not in people.settings.zones and (fault := outline_fault(zone.corners)):
            raise InvalidZones(f"zone {zone.name!r}: {fault}")
    try:
        create(settings.rule)
    except (NotFound, NotPermitted) as error:
        raise InvalidParameter(f"rule: {error}") from error
    return replace(people, settings=settings)


def _put_back(now: MapPeople, before: MapPeople, refused: MapPeople) -> MapPeople:
    return replace(now, settings=before.settings) if now.settings == refused.settings else now


async def _configure(services: Services, user: str, map_id: str, settings: PeopleSettings) -> None:
    """Send settings to the coordinator, and once more if another client has stored others meanwhile."""
    while True:
        await services.cloud.people.configure(user, map_id, settings)
        current = (await run_in_threadpool(services.store.map_people, user, map_id)).settings
        if current == settings:
            return
        settings = current
