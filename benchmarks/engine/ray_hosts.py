"""Machines on the nodes of a Ray cluster on this host."""

import asyncio
import contextlib
from collections.abc import AsyncIterator
from pathlib import Path

from benchmarks.engine.ray_cluster import LocalRayCluster, LocalRayNode
from benchmarks.engine.site import machines_beyond
from benchmarks.harness.cloud_under_test import Target


class RayHosts:
    """Provides additional machines as Ray nodes; use ``ray_hosts``.

    Parameters
    ----------
    cluster : LocalRayCluster
        Cluster that they join.
    """

    def __init__(self, cluster: LocalRayCluster[LocalRayNode]) -> None:
        self._cluster = cluster
        at = ("--ray-address", cluster.address, "--listen-machines", "127.0.0.1:0")
        self.arguments: tuple[str, ...] = ("--runtime", "ray", *at)
        self.environment = cluster.credentials

    @contextlib.asynccontextmanager
    async def joined(self, target: Target, folder: Path) -> AsyncIterator[LocalRayNode]:
        """Start a node, wait until it is a machine of the cloud, and end it afterwards."""
        known = [view["id"] for view in await target.rest.items("/v1/machines")]
        node = await asyncio.to_thread(self._cluster.join)
        try:
            node.name = (await machines_beyond(target, known))[0]
            yield node
        finally:
            await asyncio.to_thread(node.end)


@contextlib.asynccontextmanager
async def ray_hosts() -> AsyncIterator[RayHosts]:
    """Start a cluster with a node, and end it afterwards.

    Raises
    ------
    Unavailable
        It does not start.
    """
    starting = asyncio.create_task(asyncio.to_thread(LocalRayCluster, LocalRayNode))
    try:
        cluster = await asyncio.shield(starting)
    except asyncio.CancelledError:
        await asyncio.to_thread((await starting).stop)  # the thread cannot be cancelled
        raise
    try:
        await asyncio.to_thread(cluster.join)
        yield RayHosts(cluster)
    finally:
        await asyncio.to_thread(cluster.stop)
