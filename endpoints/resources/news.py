"""News between the processes of a cloud: changes that caches drop, and facts about robots."""

import asyncio
from functools import partial
from typing import Any, TypeVar

import msgspec

from endpoints.resources.joint_maps import ALONE, Sharing
from endpoints.resources.publications import PublicationProgress
from endpoints.resources.services import RefusedConnect, Services
from engine.control.news import FactKind, NewsKind
from ppaas.decoding import from_json
from storage.store_cache import StoreCache


class Caches:
    """Connects the caches of this process with the caches of others.

    Parameters
    ----------
    services : Services
        Services with the caches.
    """

    def __init__(self, services: Services) -> None:
        self._accounts = services.accounts
        self._caches: dict[NewsKind, tuple[StoreCache[Any], ...]] = {
            "map": (services.map_cache,),
            "robot": (services.shares, services.stops),
        }
        for kind, caches in self._caches.items():
            for cache in caches:
                cache.announce = partial(services.cloud.announce, kind)

    def hear(self, kind: NewsKind, key: str) -> None:
        """Drop a record that another process has changed."""
        if kind == "user":
            self._accounts.forget_user(key)
        for cache in self._caches.get(kind, ()):
            cache.drop(key)

    def drop_all(self) -> None:
        """Drop everything, as news may have been missed."""
        for caches in self._caches.values():
            for cache in caches:
                cache.drop_all()
        self._accounts.forget_all()


F = TypeVar("F")


class RobotFacts:
    """Asks this process, and the others for what it does not know.

    Parameters
    ----------
    services : Services
        Services of this process.
    """

    def __init__(self, services: Services) -> None:
        self._services = services

    async def here(self, kind: FactKind, user: str, robot: str) -> bytes | None:
        """Return a fact that this process knows as JSON; None if it does not know it."""
        known: PublicationProgress | RefusedConnect | Sharing | None
        match kind:
            case "publication":
                known = await self._progress_here(user, robot)
            case "refusal":
                known = self._services.refused_connects.last(user, robot)
            case "sharing":
                known = self._sharing_here(user, robot)
        return None if known is None else msgspec.json.encode(known)

    async def progress(self, user: str, robot: str) -> PublicationProgress | None:
        """Return how far the publication of a robot's map is; None if there is none."""
        here = await self._progress_here(user, robot)
        return here or next(iter(await self._others("publication", user, robot, PublicationProgress)), None)

    async def last_refusal(self, user: str, robot: str) -> RefusedConnect | None:
        """Return the last refusal of a robot; None if it connected since, or never tried."""
        here = self._services.refused_connects.last(user, robot)
        if here is not None:
            return here
        others = await self._others("refusal", user, robot, RefusedConnect)
        return min(others, key=lambda refused: refused.ago, default=None)

    async def sharing(self, user: str, robot: str) -> Sharing:
        """Return whether the map of a robot is part of a joint one."""
        here = self._sharing_here(user, robot)
        return here or next(iter(await self._others("sharing", user, robot, Sharing)), ALONE)

    async def _progress_here(self, user: str, robot: str) -> PublicationProgress | None:
        return await asyncio.to_thread(self._services.publications.progress, user, robot)

    def _sharing_here(self, user: str, robot: str) -> Sharing | None:
        sharing = self._services.joint_maps.sharing(user, robot)
        return None if sharing == ALONE else sharing

    async def _others(self, kind: FactKind, user: str, robot: str, fact: type[F]) -> list[F]:
        return [from_json(each, fact) for each in await self._services.cloud.facts(kind, user, robot)]
