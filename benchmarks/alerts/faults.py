"""Faults of a cloud that make alerts fire: each breaks something, and mends it."""

import asyncio
import contextlib
import json
import signal
import threading
from abc import ABC, abstractmethod
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import ClassVar

import websockets
from websockets.asyncio.client import ClientConnection

from benchmarks.harness.cloud_under_test import CloudUnderTest, logged_in
from benchmarks.harness.joining import JoinedMachine, ticket_of
from ppaas.geometry import Pose2D
from robots.client.cloud_url import path_of
from robots.client.robot_file import RobotFile
from robots.demo.cloud_process import CloudProcess

MAP = "bench-alerts"
START = Pose2D(2.0, 2.0, 0.0)
LOST_GOALS = 4
"""Number of goals that fail; three are enough for the alert."""

BETWEEN = 1.1
"""Time between two of them [s]: a counter that jumps at once is not seen to rise."""


class Site:
    """The cloud that is broken.

    Parameters
    ----------
    cloud : CloudProcess
    folder : Path
        For machines; a short path.
    """

    def __init__(self, cloud: CloudProcess, folder: Path) -> None:
        self.cloud = cloud
        self.folder = folder

    async def log_in(self) -> CloudUnderTest:
        """Return a login to the cloud as it runs now."""
        return await logged_in(self.cloud)


class CloudFault(ABC):
    """Something that breaks, and is mended.

    Parameters
    ----------
    site : Site

    Attributes
    ----------
    alert : str
        The alert that fires.
    broken, mended : str
        Descriptions of the fault, and of the action that mends it.
    """

    alert: ClassVar[str]
    broken: ClassVar[str]
    mended: ClassVar[str]

    def __init__(self, site: Site) -> None:
        self._site = site

    async def prepare(self) -> None:
        """Make what is to be broken; by default, it is there."""

    @abstractmethod
    async def break_it(self) -> None:
        """Break it."""

    async def mend(self) -> None:
        """Mend it; by default, it is over by itself."""

    async def close(self) -> None:
        """Remove what is left; by default, nothing is."""


async def connect(target: CloudUnderTest, robot: str) -> ClientConnection:
    """Register a robot, and connect as it."""
    await target.rest.put_robot(robot, RobotFile(map=MAP, initial_pose=(START.x, START.y, START.theta), cores=0.1))
    return await _connection(target, robot)


async def _connection(target: CloudUnderTest, robot: str) -> ClientConnection:
    headers = {"Authorization": f"Bearer {target.token}"}
    return await websockets.connect(f"{target.ws_url}/?robot={robot}", additional_headers=headers)


class _RobotFault(CloudFault):
    robot: ClassVar[str]

    async def prepare(self) -> None:
        """Connect the robot."""
        self._target = await self._site.log_in()
        self._socket = await connect(self._target, self.robot)

    async def close(self) -> None:
        """Disconnect it."""
        with contextlib.suppress(OSError, websockets.ConnectionClosed):
            await self._socket.close()


class LostRobot(_RobotFault):
    """A robot that disconnects and comes back."""

    alert, robot = "PPaaSRobotLost", "lost"
    broken, mended = "a robot disconnects", "it connects again"

    async def break_it(self) -> None:
        """Disconnect it."""
        await self._socket.close()

    async def mend(self) -> None:
        """Connect it again."""
        self._socket = await _connection(self._target, self.robot)


class LowBattery(_RobotFault):
    """A robot whose battery is empty, and is charged."""

    alert, robot = "PPaaSBatteryLow", "empty"
    broken, mended = "a robot reports a charge of 10 %", "it reports 90 %"

    async def prepare(self) -> None:
        """Connect the robot, which reports its charge from now on."""
        await super().prepare()
        self._charge = 0.9
        kind = {"op": "advertise", "topic": "battery_state", "type": "sensor_msgs/BatteryState"}
        await self._socket.send(json.dumps(kind))
        self._reporting = asyncio.create_task(self._report())

    async def _report(self) -> None:
        while True:
            state = {"op": "publish", "topic": "battery_state", "msg": {"percentage": self._charge}}
            await self._socket.send(json.dumps(state))
            await asyncio.sleep(1.0)

    async def break_it(self) -> None:
        """Report an empty battery."""
        self._charge = 0.1

    async def mend(self) -> None:
        """Report a full one."""
        self._charge = 0.9

    async def close(self) -> None:
        """Report no more, and disconnect."""
        self._reporting.cancel()
        await asyncio.gather(self._reporting, return_exceptions=True)
        await super().close()


class FailingGoals(CloudFault):
    """Goals of robots that disconnect for good."""

    alert = "PPaaSGoalsFailing"
    broken, mended = f"{LOST_GOALS} robots with a goal disconnect for good", "no goal fails any more"

    async def prepare(self) -> None:
        """Connect the robots, and give each a goal."""
        self._target = await self._site.log_in()
        self._sockets = [await connect(self._target, f"goal-{number}") for number in range(LOST_GOALS)]
        for number in range(LOST_GOALS):
            await self._target.rest.post(path_of("robots", f"goal-{number}", "goals"), {"pose": [3.0, 2.0, 0.0]})

    async def break_it(self) -> None:
        """Disconnect the robots one after another."""
        for socket in self._sockets:
            await socket.close()
            await asyncio.sleep(BETWEEN)


class DeadWebhook(CloudFault):
    """A webhook whose target is gone, and another one in its place."""

    alert, broken, mended = "PPaaSWebhooksFailing", "the target of a webhook answers 410", "no delivery fails any more"

    async def prepare(self) -> None:
        """Start the target, and create the webhook."""

        class Gone(BaseHTTPRequestHandler):
            def do_POST(self) -> None:
                self.rfile.read(int(self.headers["Content-Length"]))
                self.send_response(410)
                self.end_headers()

            def log_message(self, *_: object) -> None:
                """Log nothing."""

        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Gone)
        threading.Thread(target=self._server.serve_forever, daemon=True).start()
        self._rest = (await self._site.log_in()).rest
        url = f"http://127.0.0.1:{self._server.server_port}/"
        self._hook = (await self._rest.post(path_of("webhooks"), {"url": url, "events": ["task.*"]}))["id"]

    async def break_it(self) -> None:
        """Send it an event."""
        await self._rest.post(path_of("webhooks", self._hook, "test"), {})

    async def mend(self) -> None:
        """Remove the webhook."""
        await self._rest.delete(path_of("webhooks", self._hook))

    async def close(self) -> None:
        """Stop the target."""
        await asyncio.to_thread(self._server.shutdown)
        self._server.server_close()


class LostMachine(CloudFault):
    """A machine of another host that dies, and joins again."""

    alert, broken, mended = "PPaaSMachineLost", "kill -9 of a joined machine", "it joins again"

    async def prepare(self) -> None:
        """Let it join."""
        self._rest = (await self._site.log_in()).rest
        ticket = await ticket_of(self._site.cloud.folder / "data", "--host", "127.0.0.1")
        self._machine = await JoinedMachine.start("m2", self._site.folder, ticket, restarts=True)
        await self._machine.is_in(self._rest)

    async def break_it(self) -> None:
        """Kill it; as by a supervisor, it is started again."""
        self._machine.kill()

    async def mend(self) -> None:
        """Wait until it has joined again."""
        await self._machine.is_in(self._rest)

    async def close(self) -> None:
        """End it."""
        await self._machine.end()


class NoLeader(CloudFault):
    """A cloud that is killed, and started again."""

    alert, broken, mended = "PPaaSNoLeader", "kill -9 of ppaas up", "it is started again"

    async def break_it(self) -> None:
        """Kill it."""
        self._site.cloud.send(signal.SIGKILL)
        await self._site.cloud.ended()

    async def mend(self) -> None:
        """Start it again, with the same data."""
        await self._site.cloud.again()


BESIDE: tuple[type[CloudFault], ...] = (LostRobot, LowBattery, DeadWebhook, LostMachine)
"""Faults that are seen at the same time."""

LAST: tuple[type[CloudFault], ...] = (FailingGoals, NoLeader)
"""Faults that follow one after another: robots that disconnect for good are lost, too, and a leader is for all."""
