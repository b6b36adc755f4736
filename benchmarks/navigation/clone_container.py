"""Container of a clone in this process, on a simulated clock: the real links, sessions and nodes, without a cloud."""

import asyncio
import contextlib
import gc
import socket
import time
from collections import defaultdict
from collections.abc import AsyncIterator
from functools import partial
from pathlib import Path

import msgspec

from engine.container.container import Container, sessions_of
from engine.container.current_map import CurrentMap
from engine.container.endpoint_links import EndpointLink
from engine.container.executor import NodeExecutor
from engine.container.fleet_bridge import FleetBridge
from engine.container.graph_building import build_graph
from engine.container.machine_client import MachineClient
from engine.container.shared_plans import PlanningNotes, SharedPlans
from engine.protocols import machine_link, robot_link
from engine.protocols.framing import FrameStream, pack
from engine.protocols.session_frames import (
    Attach,
    ClientFrame,
    NumberedFrame,
    SessionClient,
    SessionOptions,
    SocketFrame,
)
from engine.rights.access import Access
from engine.runtimes.compilation import kernel_modules
from engine.runtimes.compilation.threading_layer import KernelThreads
from engine.specs.containers import ContainerSpec, Launch, MapVersion, RobotConfig
from ppaas.clock import ManualClock
from ppaas.errors import Unavailable
from ppaas.nodes.graph import Graph
from ppaas.nodes.jobs import run_inline
from ppaas.nodes.run_times import RunTimes
from ppaas.plans.reuse.time_estimates import Times

TURNS = 5
"""Turns of the event loop after which all that a frame causes is done."""

USER = "bench"


class NodeCpu(RunTimes):
    """CPU time of each node.

    Attributes
    ----------
    spent : dict
        CPU time by node [s].
    """

    def __init__(self) -> None:
        super().__init__(time.thread_time)
        self.spent: defaultdict[str, float] = defaultdict(float)

    def add(self, node: str, seconds: float) -> None:
        """Record the CPU time of a callback or a job."""
        self.spent[node] += seconds
        super().add(node, seconds)


class FarEnd:
    """The other end of a link, which is read and written between the turns of the container.

    Parameters
    ----------
    incoming : type
        Type of the frames of the container.
    """

    def __init__(self, incoming: object) -> None:
        self.near, self._socket = socket.socketpair()
        self._socket.setblocking(False)
        self._decoder = msgspec.msgpack.Decoder(incoming)
        self._held = b""

    def write(self, frame: msgspec.Struct) -> None:
        """Send a frame to the container."""
        self._socket.sendall(b"".join(pack(frame)))

    def read(self) -> list[msgspec.Struct]:
        """Return the frames that the container has sent."""
        with contextlib.suppress(BlockingIOError):
            while part := self._socket.recv(1 << 20):
                self._held += part
        frames = []
        while len(self._held) >= 4 and len(self._held) >= (end := 4 + int.from_bytes(self._held[:4], "big")):
            frames.append(self._decoder.decode(self._held[4:end]))
            self._held = self._held[end:]
        return frames

    def close(self) -> None:
        """Close the link."""
        self._socket.close()


class CloneContainer:
    """Container of one robot, which runs only in `settle` and `cycle`.

    Parameters
    ----------
    layers : Path
        Folder with the layers of the map.
    robot : RobotConfig
        The robot.

    Attributes
    ----------
    nodes : NodeCpu
        CPU time of the nodes.
    clock : ManualClock
        Clock of the clone [s].
    """

    def __init__(self, layers: Path, robot: RobotConfig) -> None:
        self.clock, self.nodes = ManualClock(1000.0), NodeCpu()
        self._endpoint, self._machine = FarEnd(robot_link.FromContainer), FarEnd(machine_link.FromContainer)
        self._robot = robot
        self._spec = ContainerSpec("c", USER, MapVersion("bench", "1"), 1.0, robot)
        self._launch = Launch(self._spec, str(layers), "", "", secret="", cpus=(), threads=1)
        self._frames = 0

    @contextlib.asynccontextmanager
    async def runs(self) -> AsyncIterator[None]:
        """Build the container, attach the robot's socket, and close all at the end."""
        self._home = home = NodeExecutor(lambda: None)
        home.graph = Graph(run_inline, self.clock, self.clock)
        home.graph.times = self.nodes
        threads, times = KernelThreads(1), Times()
        plans, notes = SharedPlans(times, home.elsewhere), PlanningNotes(times)
        attendants = build_graph(home.graph, self._launch, threads, CurrentMap(self._launch, plans, times, notes))
        kernel_modules.warm_loaded()
        gc.collect()
        gc.freeze()  # as in the fork server
        assert attendants is not None, "the container of a robot is attended"
        near: FrameStream[robot_link.ToContainer] = FrameStream(
            *await asyncio.open_unix_connection(sock=self._endpoint.near), robot_link.ToContainer
        )
        machine = MachineClient(
            FrameStream(*await asyncio.open_unix_connection(sock=self._machine.near), machine_link.ToContainer)
        )
        attendants.recording.connect(machine)
        endpoint, sessions = EndpointLink("", near), sessions_of(self._spec, self._robot)
        self._container = Container(
            self._launch, home, endpoint, machine, notes, attendants=attendants, sessions=sessions
        )
        bridge = FleetBridge(self._launch, home.graph, machine, partial(getattr, sessions, "robot_is_here"))
        sessions.begin(self._container, endpoint)
        works = (machine.serve(bridge.shared), self._container.serve(), self._container.keep_checkpoints())
        tasks = [asyncio.create_task(work) for work in works]
        client = SessionClient(USER, USER, self._robot.id, "robot")
        self._endpoint.write(Attach(1, client, SessionOptions(), Access.of_owner(self._robot.id), "bench"))
        try:
            yield
        finally:
            gc.unfreeze()
            home.close()
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            self._endpoint.close()
            self._machine.close()

    def say(self, frame: bytes) -> None:
        """Send a frame of rosbridge from the robot."""
        self._frames += 1
        self._endpoint.write(ClientFrame(1, NumberedFrame(self._frames, frame)))

    def share(self, messages: list[machine_link.Shared]) -> None:
        """Send what other robots on the map share."""
        for message in messages:
            self._machine.write(message)

    async def settle(self) -> float:
        """Let the container handle what has arrived; return its CPU time [s]."""
        began = time.thread_time()
        for _ in range(TURNS):
            await asyncio.sleep(0)
        return time.thread_time() - began

    def cycle(self) -> float:
        """Fire the timers that are due; return the CPU time [s]."""
        began = time.thread_time()
        self._home.graph.run_due()
        return time.thread_time() - began

    def heard(self) -> list[bytes]:
        """Return the frames of rosbridge for the robot, and answer the requests for the machine.

        Raises
        ------
        Unavailable
            The container has failed.
        """
        for request in self._machine.read():
            if isinstance(request, machine_link.SaveClone | machine_link.KeepPlan):
                self._machine.write(machine_link.Done(request.request))
        frames = self._endpoint.read()
        for frame in frames:
            if isinstance(frame, robot_link.ContainerFailed):
                raise Unavailable(f"the container failed: {frame.refusal.text}")
        return [frame.content for frame in frames if isinstance(frame, SocketFrame)]
