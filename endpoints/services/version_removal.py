"""Removal of map versions: one at the request of its owner, and the oldest after a publication."""

import logging

from endpoints.services.services import Services
from ppaas.errors import Conflict, PPaaSError

logger = logging.getLogger(__name__)


def remove_version(services: Services, owner: str, map_id: str, version: str) -> None:
    """Remove a version of a map, in a turn of its owner; blocks.

    Raises
    ------
    Conflict
        It is the current version, or robots use it.
    NotFound
        The map never had this version.
    """
    if version in _in_use(services, map_id, {version}):
        raise Conflict(f"version {version} of map {map_id!r} is in use by robots: disconnect them first")
    try:
        services.map_store.remove_versions(map_id, [version])
    finally:
        services.usage.stored.forget_map(owner, map_id)


def expire_versions(services: Services, owner: str, map_id: str) -> None:
    """Remove the oldest versions of a map beyond the number to keep, except those that robots use; blocks.

    It is called in a turn of the owner. A failure is logged: the publication before it has succeeded, and the next one
    tries again.
    """
    keep = services.keep_versions
    if keep is None:
        return
    try:
        listed = list(dict.fromkeys(one.version for one in services.map_store.versions(map_id)))
        old = set(listed[keep:])
        expired = old - _in_use(services, map_id, old)
        if expired:
            services.map_store.remove_versions(map_id, sorted(expired))
            services.usage.stored.forget_map(owner, map_id)
    except PPaaSError as error:
        logger.warning("old versions of map %r were not removed: %s", map_id, error)


def _in_use(services: Services, map_id: str, versions: set[str]) -> set[str]:
    """Return those of the versions that robots may use: as their map, or any of them as a mask."""
    containers = [one for one in services.cloud.containers(None) if one.robot is not None]
    if any(map_id in one.masks for one in containers):
        return versions
    return versions & {one.map.version for one in containers if one.map.id == map_id}
