"""Removal of map versions: one at the request of its owner, and the oldest after a publication."""

import logging
from collections.abc import Sequence

from endpoints.resources.services import Services
from engine.control.views import ContainerView
from ppaas.errors import Conflict, PPaaSError
from storage.records import MapRecord

logger = logging.getLogger(__name__)


async def remove_version(services: Services, owner: str, map_id: str, version: str) -> None:
    """Remove a version of a map.

    Raises
    ------
    Conflict
        It is the current version, or robots use it.
    NotFound
        The map never had this version.
    """
    if version in _in_use(await services.cloud.containers.views(None), map_id, {version}):
        raise Conflict(f"version {version} of map {map_id!r} is in use by robots: disconnect them first")
    await services.usage.in_turn(owner, _remove, services, owner, map_id, version)


def _remove(services: Services, owner: str, map_id: str, version: str) -> None:
    try:
        services.map_store.remove_versions(map_id, [version])
    finally:
        services.usage.stored.forget_map(owner, map_id)


async def follow_publication(services: Services, record: MapRecord) -> None:
    """Remove the oldest versions of a map after a publication, and let robots go on with its current version."""
    if services.keep_versions is not None:
        containers = await services.cloud.containers.views(None)
        await services.usage.in_turn(record.owner, expire_versions, services, record, containers)
    await services.cloud.maps.changed(record)


def expire_versions(services: Services, record: MapRecord, containers: Sequence[ContainerView]) -> None:
    """Remove the oldest versions of a map beyond the number to keep, except those that containers use; blocks.

    It is called in a turn of the owner. A failure is logged: the publication before it has succeeded, and the next one
    tries again.
    """
    keep, map_id = services.keep_versions, record.id
    if keep is None:
        return
    try:
        listed = list(dict.fromkeys(one.version for one in services.map_store.versions(map_id)))
        old = set(listed[keep:])
        expired = old - _in_use(containers, map_id, old)
        if expired:
            services.map_store.remove_versions(map_id, sorted(expired))
            services.usage.stored.forget_map(record.owner, map_id)
    except PPaaSError as error:
        logger.warning("old versions of map %r were not removed: %s", map_id, error)


def _in_use(containers: Sequence[ContainerView], map_id: str, versions: set[str]) -> set[str]:
    """Return which of the versions robots may use: as their map, or any of them as a mask."""
    of_robots = [one for one in containers if one.robot is not None]
    if any(map_id in one.masks for one in of_robots):
        return versions
    return versions & {one.map.version for one in of_robots if one.map.id == map_id}
