"""The cloud that a bench measures: its own on loopback, or one that already runs."""

import contextlib
from collections.abc import AsyncIterator
from dataclasses import dataclass

from ppaas.maps.formats.map_files import save_map
from ppaas.maps.grid import GridMap
from robots.client.rest import RestClient
from robots.client.robot_file import RobotFile
from robots.demo.cloud_process import CloudProcess

LINGER = 0.1
"""Time that a clone is kept after its robot disconnected [s]: short, to free capacity for the next measurement."""


CORES = 0.1
"""Size of a container [cores]: small enough that the machine's capacity does not limit a fleet."""


@dataclass(frozen=True, slots=True)
class CloudUnderTest:
    """A cloud under test, and a login to it.

    Parameters
    ----------
    rest : RestClient
        Logged in.
    url, token : str
        Base URL of the cloud, and the token of that login.
    pid : int, optional
        Process id of its web process; None if the bench did not start the cloud.
    """

    rest: RestClient
    url: str
    token: str
    pid: int | None

    @property
    def ws_url(self) -> str:
        """WebSocket URL for robots."""
        return self.url.replace("http", "ws", 1)

    async def publish(self, map_id: str, grid: GridMap) -> None:
        """Publish a map."""
        yaml, image = save_map(grid, "map.pgm")
        await self.rest.upload_map(map_id, yaml, image)

    async def register(
        self,
        robot: str,
        map_id: str,
        pose: tuple[float, float, float],
        cores: float = CORES,
        *,
        traffic: bool = False,
    ) -> str:
        """Register a robot, which may take part in the traffic of its map; return the URL of its WebSocket."""
        await self.rest.put_robot(robot, RobotFile(map=map_id, initial_pose=pose, cores=cores, traffic=traffic))
        return f"{self.ws_url}/?robot={robot}&token={self.token}"


@contextlib.asynccontextmanager
async def own_cloud() -> AsyncIterator[CloudUnderTest]:
    """Start a cloud and end it afterwards."""
    async with CloudProcess(arguments=("--linger", str(LINGER))) as cloud:
        yield await logged_in(cloud)


async def logged_in(cloud: CloudProcess) -> CloudUnderTest:
    """Log in to a started cloud as its administrator."""
    rest = RestClient(cloud.ready.url)
    login = await rest.login(cloud.ready.admin_user, cloud.password)
    return CloudUnderTest(rest, cloud.ready.url, login.token, cloud.ready.pid)


@contextlib.asynccontextmanager
async def running_cloud(url: str, token: str) -> AsyncIterator[CloudUnderTest]:
    """Use a cloud that already runs."""
    yield CloudUnderTest(RestClient(url, token), url, token, None)
