"""The machines of a cloud that are nodes of a Ray cluster, as the cloud has them started and ended."""

from engine.fabric.router import RouterProcess
from engine.remote.ray.watcher_process import WatcherProcess


class RayMachines:
    """Has an agent kept on each node, in place of the one agent of this machine.

    Parameters
    ----------
    watcher : WatcherProcess
        Of the cluster.
    router : RouterProcess
        Of the cloud: the routers of the nodes meet there, as there is no agent here that has one.
    """

    expected_at_start = False  # nodes may join at any time
    was_adopted: bool = False
    deaths: int = 0

    def __init__(self, watcher: WatcherProcess, router: RouterProcess) -> None:
        self._watcher = watcher
        self._router = router

    async def start(self) -> None:
        """Begin to have agents started; there may be no node yet.

        Raises
        ------
        Unavailable
            There is no such cluster, or it does not let us in.
        """
        await self._router.start()
        await self._watcher.start()

    def kill(self, machine: str) -> None:
        """End the agent of a machine by force: it is frozen, and is started again."""
        self._watcher.kill(machine)

    async def stop(self) -> None:
        """End all agents."""
        await self._watcher.stop()
        await self._router.close()
