"""Map follower: lets the clones of a machine go on with new versions of their maps, without a restart."""

import asyncio
import logging
from collections.abc import Callable
from pathlib import Path

from engine.agent.container_gateway import ContainerGateway
from engine.agent.map_cache import MapCache
from engine.protocols import control_link
from engine.specs.containers import ContainerSpec
from engine.specs.robot_layers import layers_of
from ppaas.errors import PPaaSError, Unavailable

logger = logging.getLogger(__name__)

RETRY = 2.0
"""Time after which layers that could not be made, or a container that did not answer, are tried again [s]."""


class FollowedMap:
    """Map of one container that runs on this machine: its current layers, and the versions that it is to follow.

    Parameters
    ----------
    spec : ContainerSpec
        Spec of the container.
    layers : Path
        Folder of its layers, in use for it (``MapCache.ensure``).
    used : callable
        Called with spec and layers once the container uses others.

    Attributes
    ----------
    spec, layers
        Those that it uses now.
    """

    def __init__(self, spec: ContainerSpec, layers: Path, used: Callable[[ContainerSpec, Path], None]) -> None:
        self.spec, self.layers = spec, layers
        self._used = used
        self._wanted: control_link.UseMap | None = None
        self._closed = False
        self._task: asyncio.Task[None] | None = None

    def follow(self, order: control_link.UseMap, cache: MapCache, gateway: ContainerGateway) -> None:
        """Follow the versions of an order; of several orders, the last counts."""
        self._wanted = order
        if self._task is None or self._task.done():
            self._task = asyncio.create_task(self._run(cache, gateway))

    async def close(self, cache: MapCache) -> None:
        """Follow no more versions, because the container has exited, and release its layers."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)
        cache.release(self.layers)

    async def _run(self, cache: MapCache, gateway: ContainerGateway) -> None:
        while (order := self._wanted) is not None:
            self._wanted = None
            try:
                await self._follow(order, cache, gateway)
            except Unavailable as error:
                logger.warning("container %s does not follow its map yet: %s", self.spec.id, error)
                self._wanted = self._wanted or order
                await asyncio.sleep(RETRY)
            except PPaaSError as error:
                logger.error("container %s goes on with the map before: %s", self.spec.id, error)
            except Exception:
                logger.exception("container %s goes on with the map before after an internal error", self.spec.id)

    async def _follow(self, order: control_link.UseMap, cache: MapCache, gateway: ContainerGateway) -> None:
        spec = self.spec.on_maps(order.map, order.masks, in_space=order.in_space)
        if spec == self.spec:
            return
        layers = await cache.ensure(layers_of(spec))
        try:
            await gateway.until_attached(spec.id)
            await gateway.use_layers(spec, layers, await cache.changes(self.layers, layers))
        except BaseException:
            cache.release(layers)
            raise
        before, self.spec, self.layers = self.layers, spec, layers
        cache.release(before)
        self._used(spec, layers)
