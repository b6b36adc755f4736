"""The cloud that a bench measures: one of its own on loopback, or one that is up."""

import contextlib
from collections.abc import AsyncIterator
from dataclasses import dataclass

from ppaas.maps.formats.map_files import save_map
from ppaas.maps.grid import GridMap
from robots.client.rest import RestClient
from robots.client.robot_file import RobotFile
from robots.demo.cloud_process import CloudProcess

LINGER = 0.1
"""Seconds that a clone is kept after its robot left: the next measurement is to find its room."""


CORES = 0.1
"""Size of a container: so small that the machine's capacity is not what limits a fleet."""


@dataclass(frozen=True, slots=True)
class Target:
    """A cloud, and who asks it.

    Parameters
    ----------
    rest : RestClient
        Logged in.
    url, token : str
        Where it is and the token of that login.
    pid : int, optional
        Of its web process, where it is the bench's own.
    """

    rest: RestClient
    url: str
    token: str
    pid: int | None

    @property
    def ws_url(self) -> str:
        """Where robots connect."""
        return self.url.replace("http", "ws", 1)

    async def publish(self, map_id: str, grid: GridMap) -> None:
        """Publish a map."""
        yaml, image = save_map(grid, "map.pgm")
        await self.rest.upload_map(map_id, yaml, image)

    async def register(self, robot: str, map_id: str, pose: tuple[float, float, float], cores: float = CORES) -> str:
        """Tell of a robot; return the URL of its WebSocket."""
        await self.rest.put_robot(robot, RobotFile(map=map_id, initial_pose=pose, cores=cores))
        return f"{self.ws_url}/?robot={robot}&token={self.token}"


@contextlib.asynccontextmanager
async def own_cloud() -> AsyncIterator[Target]:
    """Start a cloud and end it afterwards."""
    async with CloudProcess(arguments=("--linger", str(LINGER))) as cloud:
        yield await logged_in(cloud)


async def logged_in(cloud: CloudProcess) -> Target:
    """Return a cloud of one's own, as its administrator."""
    rest = RestClient(cloud.ready.url)
    login = await rest.login(cloud.ready.admin_user, cloud.password)
    return Target(rest, cloud.ready.url, login.token, cloud.ready.pid)


@contextlib.asynccontextmanager
async def running_cloud(url: str, token: str) -> AsyncIterator[Target]:
    """Take a cloud that is up."""
    yield Target(RestClient(url, token), url, token, None)
