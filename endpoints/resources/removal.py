"""Removal of users and robots: what names them ends before the id is free again, also if a process dies meanwhile.

A user who is to be removed is marked first, which takes all rights and keeps the id taken. Each step after that can be
repeated, and the last one frees the id. So a removal that was interrupted is finished by what comes first: the next
request to remove the user, one to create a user of that id, or the job `RemovedUsers`.
"""

import asyncio
import logging
from collections.abc import Collection
from contextlib import suppress

from msgspec.structs import replace
from starlette.concurrency import run_in_threadpool

from endpoints.accounts.user_lookup import find_user
from endpoints.resources.services import Services
from endpoints.sharing.shared_robots import end_shares
from engine.master.quotas import NO_LIMITS
from ppaas.errors import Conflict, Damaged, NotAuthenticated, NotFound, PPaaSError
from storage.ports import MapStore, Store
from storage.sharing_records import GROUP

logger = logging.getLogger(__name__)

PERIOD = 300.0
"""Time between two looks for removals that were interrupted [s]."""


async def remove_user(services: Services, user_id: str) -> None:
    """Remove a user with all that belongs to the user or names the user as somebody with rights.

    Raises
    ------
    NotFound
        The user does not exist.
    """
    with suppress(Damaged):  # nobody can log in as such a user, and a removal that is interrupted is asked for again
        await services.accounts.begin_removal(user_id)
    await _finish(services, user_id)


async def make_user_free(services: Services, user_id: str) -> None:
    """Remove what is left of a former user of an id, unless somebody has the id; finish an interrupted removal."""
    user = await find_user(services.store, user_id)
    if user is not None and user.leaving:
        await _finish(services, user_id)
    elif user is None:
        await run_in_threadpool(_forget_late, services.store, user_id)
        await services.data_folder.remove_recordings(user_id, None)


class RemovedUsers:
    """Job that finishes removals which were interrupted.

    Parameters
    ----------
    services : Services
    """

    def __init__(self, services: Services) -> None:
        self._services = services

    async def run(self) -> None:
        """Look from time to time, until cancelled."""
        while True:
            try:
                await self.look()
            except PPaaSError as error:
                logger.warning("removals of users cannot be finished now: %s", error)
            await asyncio.sleep(PERIOD)

    async def look(self) -> None:
        """Finish all removals that have begun."""
        for user in await run_in_threadpool(self._services.store.users):
            if user.leaving:
                logger.info("finishing the removal of user %s", user.id)
                await _finish(self._services, user.id)


async def _finish(services: Services, user_id: str) -> None:
    removed = NotAuthenticated("this user was removed")
    # Containers that run on would store their checkpoints again.
    await services.cloud.users.end_places(user_id, removed)
    await _end_rights(services, user_id)
    await services.data_folder.remove_recordings(user_id, None)
    with suppress(NotFound):  # somebody else has finished the same removal
        await services.accounts.remove(user_id)
    services.usage.stored.forget_user(user_id)
    await services.cloud.users.end_places(user_id, removed)  # of robots that connected meanwhile
    await services.data_folder.remove_recordings(user_id, None)
    await services.cloud.set_limits(user_id, NO_LIMITS)


async def _end_rights(services: Services, user_id: str) -> None:
    """End what others have given the user: maps, buildings, robots, and groups that end with their last member."""
    for map_id, owner in await run_in_threadpool(_read_maps, services.map_store, user_id):
        await services.usage.in_turn(owner, _end_reading, services.map_store, map_id, user_id)
        services.map_cache.forget(map_id)
    await run_in_threadpool(_end_reading_of_buildings, services.store, user_id)
    await end_groups(services, user_id)
    await _end_shares(services, user_id)


async def end_groups(services: Services, user_id: str, staying: Collection[str] = ()) -> None:
    """End the shares of groups that end because their only member leaves them; ``staying`` are those it stays in."""
    for group in await run_in_threadpool(_groups_of_one, services.store, user_id):
        if group not in staying:
            await _end_shares(services, GROUP + group)


async def _end_shares(services: Services, grantee: str) -> None:
    for robot in await run_in_threadpool(end_shares, services.store, grantee):
        services.shares.forget_robot(robot.user, robot.id)


def _groups_of_one(store: Store, user_id: str) -> list[str]:
    users = store.users()
    others = {group for user in users if user.id != user_id and not user.leaving for group in user.groups}
    return [group for user in users if user.id == user_id for group in user.groups if group not in others]


def _read_maps(map_store: MapStore, user_id: str) -> list[tuple[str, str]]:
    return [(head.id, head.owner) for head in map_store.maps(user_id) if user_id in head.readers]


def _end_reading(map_store: MapStore, map_id: str, user_id: str) -> None:
    with suppress(NotFound):  # removed meanwhile
        readers = map_store.map_head(map_id).readers
        if user_id in readers:
            map_store.change_map(map_id, readers=tuple(reader for reader in readers if reader != user_id))


def _end_reading_of_buildings(store: Store, user_id: str) -> None:
    for owner in store.building_users():
        for building in store.buildings(owner):
            with suppress(NotFound):  # removed meanwhile
                while user_id in (record := store.building(*building.key)).readers:
                    kept = tuple(reader for reader in record.readers if reader != user_id)
                    with suppress(Conflict):  # changed meanwhile
                        store.put_building(replace(record, readers=kept), instead_of=record)


def _forget_late(store: Store, user_id: str) -> None:
    """Remove what requests which were on their way have stored for a user who was gone."""
    for robot in store.robots(user_id):
        with suppress(NotFound):
            store.remove_robot(user_id, robot.id)
    for owner, map_id in store.task_groups():
        if owner == user_id:
            for task in store.tasks(user_id, map_id):
                store.remove_task(user_id, map_id, task.task.id)
    for building in store.buildings(user_id):
        with suppress(NotFound):
            store.remove_building(user_id, building.id)
    for hook in store.webhooks(user_id):
        with suppress(NotFound):
            store.remove_webhook(user_id, hook.id)


# Robots: their files, recordings, checkpoints, shares, and the tokens that are for them alone.


async def remove_robot(services: Services, owner: str, robot: str) -> None:
    """Remove a robot with all that is of it. The robot itself is last, so an interrupted removal can be repeated.

    Raises
    ------
    NotFound
        The robot does not exist.
    """
    for token in await run_in_threadpool(_own_tokens, services.store, owner, robot):
        with suppress(NotFound):  # revoked meanwhile
            await services.accounts.revoke(owner, token)
    await services.data_folder.remove_recordings(owner, robot)
    await services.usage.in_turn(owner, _remove_robot, services, owner, robot)
    services.shares.forget_robot(owner, robot)
    await services.data_folder.remove_recordings(owner, robot)


async def make_robot_free(services: Services, owner: str, robot: str) -> None:
    """Remove what a former robot of an id has left; there is none of that id now."""
    await run_in_threadpool(services.store.remove_clone, owner, robot)
    await services.data_folder.remove_recordings(owner, robot)


def _own_tokens(store: Store, owner: str, robot: str) -> list[str]:
    names = {robot, f"{owner}:{robot}"}
    return [
        token.hash
        for token in store.tokens(owner)
        if token.scope is not None and set(token.scope.robots) <= names
    ]  # fmt: skip


def _remove_robot(services: Services, owner: str, robot: str) -> None:
    services.store.remove_robot(owner, robot)
    services.usage.stored.forget_urdf(owner, robot)
