"""Machines of a cloud that are nodes of a Ray cluster; the cloud starts and stops their agents."""

from engine.fabric.router import RouterProcess
from engine.remote.ray.watcher_process import WatcherProcess


class RayMachines:
    """Keeps an agent on each node, in place of the agent of the local machine.

    Parameters
    ----------
    watcher : WatcherProcess
        Watcher of the cluster.
    router : RouterProcess
        Router of the cloud, which the routers of the nodes connect to. There is no local agent to start it.
    """

    expected_at_start = False  # nodes may join at any time
    was_adopted: bool = False
    deaths: int = 0

    def __init__(self, watcher: WatcherProcess, router: RouterProcess) -> None:
        self._watcher = watcher
        self._router = router

    async def start(self) -> None:
        """Start the watcher, which starts agents. There may be no node yet.

        Raises
        ------
        Unavailable
            The cluster does not exist, or refuses the connection.
        """
        await self._router.start()
        await self._watcher.start()

    def kill(self, machine: str) -> None:
        """Kill the frozen agent of a machine; it is restarted."""
        self._watcher.kill(machine)

    async def stop(self) -> None:
        """Stop all agents."""
        await self._watcher.stop()
        await self._router.close()
