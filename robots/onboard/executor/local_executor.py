"""Local executor: runs nodes in a separate process, so a busy or crashing node does not block the robot's program.

It reads commands from its standard input and writes answers and messages to its standard output. It exits when the
parent closes its input.

It drives a short simulated way before the first node is taken over, which compiles all kernels.
"""

import asyncio
import contextlib
import logging
import math
import os
import sys
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

import msgspec

from ppaas.change_log import LogEntry
from ppaas.clock import ManualClock
from ppaas.clone.assembly import build_clone
from ppaas.clone.robot_body import robot_body
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from ppaas.log_lines import log_lines
from ppaas.maps.occupancy import from_message
from ppaas.messages import decode, encode, type_name
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseStamped, PoseWithCovariance, Twist, TwistWithCovariance
from ppaas.messages.nav_msgs import OccupancyGrid, Odometry
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.nodes.base import Checkpoint, Payload
from ppaas.nodes.graph import Graph
from ppaas.nodes.jobs import TURN, LongWork, Work
from ppaas.nodes.map_server.node import KEEPOUT_MASK, SPEED_MASK
from ppaas.zones.reading import zones_of
from ppaas.zones.zone import NO_ZONES
from robots.onboard.executor import protocol

CYCLES = 30
"""Number of sensor cycles."""
PERIOD = 0.05
"""Simulated time of a cycle [s]."""
BEAMS = 360
"""Number of beams of the simulated scan."""
EPOCH = 1e9
"""Stamp of the start [seconds since the epoch]."""


def warm_up(build: Callable[[Graph], None], initial_pose: Pose2D) -> None:
    """Drive a clone for a moment in simulated time.

    Parameters
    ----------
    build : callable
        Adds all nodes of the clone to a graph.
    initial_pose : Pose2D
        Pose of the robot in the frame ``map``.
    """
    clock = ManualClock()
    graph = Graph(clock=clock, stamp_clock=lambda: EPOCH + clock())
    build(graph)
    ahead = initial_pose @ Pose2D(0.5, 0.0, 0.0)
    for cycle in range(CYCLES):
        clock.advance(PERIOD)
        # The pose may be inside an obstacle: the warm-up then covers less, which is not an error.
        with contextlib.suppress(PPaaSError):
            _sense(graph, 0.02 * cycle)
            if cycle == CYCLES // 3:
                graph.inject("move_base_simple/goal", PoseStamped(Header(frame_id="map"), Pose.of(ahead)))
            graph.run_due()


def _sense(graph: Graph, travelled: float) -> None:
    stamp = Time.of(graph.now())
    pose = PoseWithCovariance(Pose.of(Pose2D(travelled, 0.0)))
    odometry = Odometry(Header(stamp=stamp, frame_id="odom"), "base_link", pose, TwistWithCovariance(Twist()))
    graph.inject("odom", odometry)
    scan = LaserScan(
        Header(stamp=stamp, frame_id="base_link"),
        angle_min=-math.pi,
        angle_max=math.pi,
        angle_increment=2.0 * math.pi / BEAMS,
        range_min=0.1,
        range_max=8.0,
        ranges=[2.0] * BEAMS,
    )
    graph.inject("scan", scan)


logger = logging.getLogger(__name__)

T = TypeVar("T")


class LocalExecutor:
    """Runs nodes of a clone on an event loop, their jobs in a thread, and long jobs in others.

    Parameters
    ----------
    write : callable
        Called with each frame for the parent process.
    """

    def __init__(self, write: Callable[[protocol.FromExecutor], None]) -> None:
        self._write = write
        self._loop = asyncio.get_running_loop()
        self._executor = ThreadPoolExecutor(1, "job")
        self._long_jobs = ThreadPoolExecutor(2, "long-job")
        self._alarm: asyncio.TimerHandle | None = None
        self._config: protocol.CloneConfig | None = None
        self._layers: MapLayers | None = None
        self.graph = Graph(self._work)
        self.graph.tap_published(self._on_published)

    # -- commands ------------------------------------------------------------------------------------------------------

    def take(self, frame: protocol.ToExecutor) -> None:
        """Execute a command; report its error if it fails."""
        try:
            self._take(frame)
        except PPaaSError as error:
            if isinstance(frame, protocol.Tell):
                logger.warning("a message of %s was rejected: %s", frame.topic, error)
            else:
                self._write(protocol.NodeFailed(getattr(error, "slug", PPaaSError.slug), str(error)))
        self._run_timers()

    def _take(self, frame: protocol.ToExecutor) -> None:
        match frame:
            case protocol.Begin():
                self._begin(frame)
            case protocol.Add():
                self._write(self._add(frame))
            case protocol.Remove():
                rows, obsolete = self._log_change(frame.node)
                state = (self.graph.remove(frame.node) or b"").decode()
                self._write(protocol.Removed(frame.node, state, rows, obsolete))
            case protocol.Tell() if frame.topic in self.graph.topics:
                self._tell(frame)
            case protocol.AskStates():
                self._write(protocol.States(self._states()))
            case protocol.NodeCall():
                self._call(frame)

    def _tell(self, frame: protocol.Tell) -> None:
        message = decode(self.graph.topic(frame.topic).type, frame.payload)
        if frame.node:
            self.graph.deliver_to(frame.node, frame.topic, message)
        else:
            self.graph.inject(frame.topic, message)

    def _call(self, frame: protocol.NodeCall) -> None:
        def reply(result: Payload | PPaaSError) -> None:
            if isinstance(result, PPaaSError):
                self._write(protocol.Replied(frame.call, slug=result.slug, text=str(result)))
            else:
                self._write(protocol.Replied(frame.call, msgspec.Raw(encode(_message(result)))))

        try:
            request = decode(self.graph.service(frame.service).type.request, frame.request)
            self.graph.call(frame.service, request, reply)
        except PPaaSError as error:
            reply(error)
        except Exception as error:  # a faulty call must not end the process that drives the robot
            logger.exception("service %s failed in its node", frame.service)
            reply(PPaaSError(f"internal error: {type(error).__name__}"))

    def _begin(self, frame: protocol.Begin) -> None:
        layers = None if frame.config.new_map else _layers(frame, decode(OccupancyGrid, frame.map))
        self._config, self._layers = frame.config, layers
        # The robot starts at the origin of a new map.
        warm_up(self._build, Pose2D(*frame.config.initial_pose) if self._layers is not None else Pose2D(0.0, 0.0))
        self._write(protocol.ExecutorReady())

    def _build(self, graph: Graph, node: str | None = None) -> None:
        if self._config is None:
            raise PPaaSError("the executor has no configuration yet; send Begin first")
        config = self._config
        build_clone(
            graph,
            self._layers,
            model=config.model,
            urdf=config.urdf,
            initial_pose=config.initial_pose,
            base_global_planner=config.base_global_planner,
            base_local_planner=config.base_local_planner,
            parameters=config.parameters,
            only=None if node is None else (node,),
            robot=config.id,
        )

    def _add(self, frame: protocol.Add) -> protocol.Added:
        self._build(self.graph, frame.node)
        if frame.state:
            self.graph.restore([Checkpoint(frame.node, frame.state.encode())])
        node = self.graph.nodes[frame.node]
        if frame.log:
            node.restore_log([LogEntry(*row) for row in frame.log])
        hears = [protocol.TopicName(topic.name, type_name(topic.type)) for topic in node.subscribes]
        serves = [protocol.ServiceName(service.name, service.type.name) for service in node.services]
        return protocol.Added(frame.node, hears, list(self.graph.published_by(node)), serves)

    def _states(self) -> dict[str, protocol.NodeReport]:
        times = self.graph.times.take()
        states = {checkpoint.node: checkpoint.state.decode() for checkpoint in self.graph.checkpoints()}
        return {
            node: protocol.NodeReport(states.get(node, ""), _mean(times.get(node)), *self._log_change(node))
            for node in self.graph.nodes
        }

    def _log_change(self, node: str) -> tuple[list[protocol.LogRow], list[int]]:
        """Return the rows that a node's log has added since the last call, and the numbers of those removed."""
        change = self.graph.nodes[node].log_change() if node in self.graph.nodes else None
        return (
            ([], []) if change is None else ([(entry.number, entry.data) for entry in change.entries], change.obsolete)
        )

    # -- execution of nodes --------------------------------------------------------------------------------------------

    def _on_published(self, topic: str, payload: Payload) -> None:
        message = _message(payload)
        self._write(protocol.Said(topic, type_name(type(message)), msgspec.Raw(encode(message))))

    def _work(self, work: Work[T], cancelled: Callable[[], bool], done: Callable[[T | PPaaSError], None]) -> None:
        def schedule_finish(ended: "Future[T]") -> None:
            self._loop.call_soon_threadsafe(self._finish, ended, done)

        long = isinstance(work, LongWork)
        if long:
            sys.setswitchinterval(TURN)
        executor = self._long_jobs if long else self._executor
        executor.submit(work, cancelled).add_done_callback(schedule_finish)

    def _finish(self, ended: "Future[T]", done: Callable[[T | PPaaSError], None]) -> None:
        error = ended.exception()
        if error is None:
            done(ended.result())
        else:
            if not isinstance(error, PPaaSError):
                logger.error("a job of a node failed", exc_info=error)
            done(error if isinstance(error, PPaaSError) else PPaaSError(f"internal error: {type(error).__name__}"))
        self._run_timers()

    def _run_timers(self) -> None:
        """Fire the due timers, and schedule the next call."""
        if self._alarm is not None:
            self._alarm.cancel()
        self._alarm = self._loop.call_later(min(self.graph.run_due(), 3600.0), self._run_timers)


def _layers(frame: protocol.Begin, grid: OccupancyGrid) -> MapLayers:
    masks = {name: from_message(decode(OccupancyGrid, mask)) for name, mask in frame.masks.items()}
    body = robot_body(frame.config.model, frame.config.urdf, frame.config.parameters)
    return build_layers(
        from_message(grid),
        robot_radius=body.robot_radius,
        keepout=masks.get(KEEPOUT_MASK),
        speed=masks.get(SPEED_MASK),
        zones=zones_of(frame.zones) if frame.zones else NO_ZONES,
    )


def _message(payload: Payload) -> Message:
    return payload if isinstance(payload, Message) else payload.to_message()


def _mean(times: tuple[int, float] | None) -> float:
    return times[1] / times[0] if times is not None else 0.0


async def serve(output: int) -> None:
    """Execute commands until the standard input ends."""
    reader = asyncio.StreamReader(limit=protocol.MAX_LINE)
    loop = asyncio.get_running_loop()
    await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), sys.stdin.buffer)
    transport, _ = await loop.connect_write_pipe(asyncio.BaseProtocol, os.fdopen(output, "wb", 0))
    executor = LocalExecutor(lambda frame: transport.write(protocol.line(frame)))
    while line := await reader.readline():
        executor.take(protocol.to_executor.decode(line))


def main() -> None:
    """Serve on the standard input and output; output of other code goes to the standard error."""
    output = os.dup(1)
    os.dup2(2, 1)
    log_lines("%(levelname)s local node: %(message)s")
    asyncio.run(serve(output))
    os._exit(0)  # do not wait for a job that still runs in the thread
