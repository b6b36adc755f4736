"""Real cloud for tests: ``ppaas up`` in a child process, with clients over real sockets."""

import json
import signal
import subprocess
import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import psutil

from engine.agent import main as agent_main
from engine.fabric import router as router_main
from ppaas.maps.formats.map_files import save_map
from ppaas.maps.grid import GridMap
from robots import cli
from robots.client.rest import RestClient
from robots.client.robot_file import RobotFile
from tests.support.waiting import stretch

ADMIN_PASSWORD = "correct horse battery"
START_TIMEOUT, END_TIMEOUT, FAMILY_TIMEOUT = 90.0, 20.0, 5.0
"""Time limits until a cloud serves, until it has ended, and from then until its processes have [s]; see `stretch`."""

LOG_SHOWN = 40_000
"""Number of characters of the cloud's log that a failed test prints."""


@dataclass
class RunningCloud:
    """A running cloud."""

    url: str
    pid: int
    log: Path
    status: int = 0
    """Expected exit status; a test that kills the cloud sets it."""
    token: str | None = None
    """Token of admin: a login takes a sixth of a second of a core, as it should."""

    @property
    def ws_url(self) -> str:
        """URL of the robot socket."""
        return self.url.replace("http", "ws", 1)

    def children(self) -> list[psutil.Process]:
        """Return all descendants of the web process, oldest first."""
        return psutil.Process(self.pid).children(recursive=True)

    def find(self, *words: str) -> list[psutil.Process]:
        """Return the descendants of the web process whose command line contains all words."""
        return named(self.children(), *words)

    def agent(self) -> psutil.Process:
        """Return the agent's process."""
        (found,) = self.find(agent_main.__name__)
        return found

    def router(self) -> psutil.Process:
        """Return the process of the machine's router."""
        (found,) = self.find(router_main.__name__)
        return found

    def fork_server(self) -> psutil.Process:
        """Return the fork server of the containers."""
        (found,) = named(self.agent().children(), "forkserver")
        return found

    def container(self) -> psutil.Process:
        """Return the process of the newest container."""
        return max(self.fork_server().children(), key=lambda process: process.create_time())

    async def admin(self) -> RestClient:
        """Return a client that is logged in as admin."""
        client = RestClient(self.url, self.token)
        if self.token is None:
            self.token = (await client.login("admin", ADMIN_PASSWORD)).token
        return client


def named(processes: Iterable[psutil.Process], *words: str) -> list[psutil.Process]:
    """Return the processes whose command line contains all words; processes that exit meanwhile are left out."""
    found = []
    for process in processes:
        with suppress(psutil.NoSuchProcess):
            if all(word in " ".join(process.cmdline()) for word in words):
                found.append(process)
    return found


def shared_memory(pid: int) -> list[Path]:
    """Return the folders in shared memory of a machine, given its agent's process id."""
    return list(Path("/dev/shm").glob(f"ppaas-*-{pid}-*"))


@contextmanager
def running_cloud(folder: Path, *arguments: str) -> Iterator[RunningCloud]:
    """Start a cloud with its data in a folder; stop it with SIGTERM, and check that it leaves nothing behind."""
    password = folder / "password"
    password.write_text(ADMIN_PASSWORD)
    ready = folder / "ready.json"
    log = folder / "cloud.log"
    command = [
        sys.executable, "-m", cli.__name__, "up", "--port", "0", "--data", str(folder / "data"),
        "--admin-password-file", str(password), "--ready-file", str(ready), *arguments,
    ]  # fmt: skip
    with log.open("wb") as output:
        process = subprocess.Popen(command, stdout=output, stderr=output)
    try:
        _wait_until_ready(process, ready, log)
        found = json.loads(ready.read_text())
        cloud = RunningCloud(found["url"], found["pid"], log)
        yield cloud
        family = cloud.children()
    except BaseException:
        sys.stdout.write(log.read_text()[-LOG_SHOWN:])  # shown with the failure
        raise
    finally:
        process.send_signal(signal.SIGTERM)
        try:
            status = process.wait(END_TIMEOUT * stretch())
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            raise AssertionError(f"the cloud did not end on SIGTERM:\n{log.read_text()}") from None
    assert status == cloud.status, log.read_text()
    _, alive = psutil.wait_procs(family, FAMILY_TIMEOUT * stretch())
    assert not alive, f"left behind: {alive}"
    assert not any(shared_memory(child.pid) for child in family)


def _wait_until_ready(process: subprocess.Popen[bytes], ready: Path, log: Path) -> None:
    began = time.monotonic()
    while not ready.exists():
        elapsed = time.monotonic() - began
        if process.poll() is not None or (elapsed > START_TIMEOUT and elapsed > START_TIMEOUT * stretch()):
            raise AssertionError(f"the cloud did not come up:\n{log.read_text()}")
        time.sleep(0.02)


async def publish_map(rest: RestClient, map_id: str, grid: GridMap) -> None:
    """Upload a map."""
    yaml, image = save_map(grid, f"{map_id}.pgm")
    await rest.upload_map(map_id, yaml, image)


async def register_robot(
    rest: RestClient,
    robot_id: str,
    map_id: str,
    pose: tuple[float, float, float],
    parameters: dict[str, dict[str, Any]] | None = None,
) -> str:
    """Register a robot, with parameters of its nodes; return the token for its connection."""
    robot = RobotFile(map=map_id, initial_pose=pose, cores=0.25, parameters=parameters or {})
    await rest.put_robot(robot_id, robot)
    assert rest.token is not None
    return rest.token
