"""CPU time of a clone for each second in which its robot drives, by cause and by node.

A simulated Turtlebot drives from goal to goal in a warehouse. Its frames go through the real links and sessions of a
container in this process; the clock is simulated, so that the result does not depend on what else the machine does.
"""

import json
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import cycle
from pathlib import Path

import uvloop

from benchmarks.navigation.clone_container import USER, CloneContainer
from engine.protocols import machine_link
from engine.specs.containers import RobotConfig
from engine.specs.layer_files import write_layers
from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D
from ppaas.maps.generate import warehouse
from ppaas.messages import decode, encode
from ppaas.messages.actionlib_msgs import GoalID
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseStamped, PoseWithCovariance, Twist, Vector3
from ppaas.messages.move_base_msgs import MoveBaseActionGoal, MoveBaseGoal
from ppaas.messages.ppaas_msgs import RobotState
from ppaas.robot_model.known_models import robot_model
from robots.sim.courses import Course, CoursePlanner
from robots.sim.driver import FixedRate, SensorRates
from robots.sim.robot import SimulatedRobot
from robots.sim.world import World

MODEL = "turtlebot2"
SIDES = 45.0, 30.0
"""Sides of the warehouse [m]."""

WARM = 4.0
"""Simulated time before the measurement [s]."""

BATCHES = 10.0
"""Rate at which positions of other robots arrive [Hz]; each of them shares its own half as often."""

CAUSES = ("control cycles", "scans", "odometry", "other robots")


@dataclass
class Spent:
    """CPU time of a drive.

    Parameters
    ----------
    seconds : float
        Simulated time [s].
    causes, nodes : dict
        CPU time by cause, and of that by node [s].
    commands : int
        Number of commands.
    frames : list of bytes
        The last frames of the robot.
    """

    seconds: float = 0.0
    causes: defaultdict[str, float] = field(default_factory=lambda: defaultdict(float))
    nodes: dict[str, float] = field(default_factory=dict)
    commands: int = 0
    frames: list[bytes] = field(default_factory=list)


def measure(seconds: float, others: int, done: Callable[[], object] = lambda: None) -> Spent:
    """Drive for a simulated time [s] with a number of other robots on the map.

    Raises
    ------
    PPaaSError
        The container has failed.
    """
    grid = warehouse(3, *SIDES)
    [course] = CoursePlanner(grid, 1).choose(1, 6)
    with tempfile.TemporaryDirectory(prefix="ppaas-bench-") as folder:
        layers = Path(folder)
        write_layers(layers, build_layers(grid, robot_radius=robot_model(MODEL).robot_radius), created=0.0)
        world = World(grid, 1)
        drive = _Drive(layers, world, world.add_robot(course.start), course, others)
        uvloop.run(drive.run(seconds, done))
    return drive.spent


class _Drive:
    def __init__(self, layers: Path, world: World, body: SimulatedRobot, course: Course, others: int) -> None:
        robot = RobotConfig("tb", MODEL, (course.start.x, course.start.y, course.start.theta), "dijkstra", "dwa", {})
        self.spent = Spent()
        self._clone = CloneContainer(layers, robot)
        self._world, self._body, self._others = world, body, others
        self._goals = cycle((*course.goals, course.start))
        self._start, self._arrived, self._sent = course.start, True, 0

    async def run(self, seconds: float, done: Callable[[], object]) -> None:
        rates, world = SensorRates(), self._world
        odometry, scan, batch = (FixedRate(rate, 0.0) for rate in (rates.odom, rates.scan, BATCHES))
        world.epoch = self._clone.clock() - world.time()
        async with self._clone.runs():
            for topic in ("cmd_vel", "move_base/result"):
                self._clone.say(json.dumps({"op": "subscribe", "topic": topic, "queue_length": 1}).encode())
            while world.time() < WARM + seconds:
                if world.time() < WARM:
                    self.spent = Spent()
                    self._clone.nodes.spent.clear()
                world.step()
                self._clone.clock.advance(world.dt)
                if odometry.take(world.time()):
                    await self._publish("odometry", "odom", self._body.odometry())
                if scan.take(world.time()):
                    await self._publish("scans", "scan", self._body.scan())
                if self._others and batch.take(world.time()):
                    self._clone.share(self._states())
                    self.spent.causes["other robots"] += await self._clone.settle()
                if self._arrived and world.time() > 1.0:
                    await self._send_goal()
                self.spent.causes["control cycles"] += self._clone.cycle() + await self._clone.settle()
                self._take(self._clone.heard())
                self.spent.seconds += world.dt
                done()
            self.spent.nodes = dict(self._clone.nodes.spent)

    async def _publish(self, cause: str, topic: str, message: Message) -> None:
        frame = b'{"op":"publish","topic":"%s","msg":%s}' % (topic.encode(), encode(message))
        self.spent.frames = [*self.spent.frames[-29:], frame]
        self._clone.say(frame)
        self.spent.causes[cause] += await self._clone.settle()

    async def _send_goal(self) -> None:
        target = PoseStamped(Header(frame_id="map"), Pose.of(next(self._goals)))
        self._arrived, self._sent = False, self._sent + 1
        goal = MoveBaseActionGoal(MoveBaseGoal(target), GoalID(id=f"goal-{self._sent}"))
        await self._publish("control cycles", "move_base/goal", goal)

    def _states(self) -> list[machine_link.Shared]:
        """Return what half of the other robots share, which drive in a row beside the start."""
        header, states = Header(stamp=Time.of(self._clone.clock()), frame_id="map"), []
        first = round(self._world.time() * BATCHES) % 2
        for number in range(first, self._others, 2):
            pose = Pose.of(Pose2D(self._start.x + 0.5 * (number + 2), self._start.y))
            state = RobotState(header, PoseWithCovariance(pose), Twist(Vector3(x=0.2)), radius=0.2)
            states.append(machine_link.Shared(USER, f"other-{number}", "amcl_pose", encode(state)))
        return states

    def _take(self, frames: list[bytes]) -> None:
        for frame in frames:
            heard = json.loads(frame)
            if heard.get("topic") == "cmd_vel":
                self.spent.commands += 1
                self._body.command(decode(Twist, json.dumps(heard["msg"])))
            self._arrived = self._arrived or heard.get("topic") == "move_base/result"


def rows(spent: Spent) -> list[dict[str, object]]:
    """Return the CPU time for a second of driving [ms]: in all, by cause and by node; and a yardstick.

    The yardstick is what ``json`` takes to read and write the frames that the robot sends in a second.
    """
    causes = {cause: spent.causes[cause] / spent.seconds for cause in CAUSES}
    nodes = {node: seconds / spent.seconds for node, seconds in sorted(spent.nodes.items(), key=lambda item: -item[1])}
    told = {"in all": sum(causes.values()), **causes}
    told |= {f"node {node}": seconds for node, seconds in nodes.items() if seconds >= 5e-5}
    told["links, sessions, executor"] = told["in all"] - sum(nodes.values())
    told["json, the same frames"] = _yardstick(spent.frames)
    return [{"work": work, "ms": round(1e3 * seconds, 2)} for work, seconds in told.items()]


def _yardstick(frames: list[bytes]) -> float:
    """Return the shortest CPU time in which ``json`` reads and writes the frames of a second [s]."""
    took = []
    for _ in range(20):
        began = time.thread_time()
        for frame in frames:
            json.dumps(json.loads(frame))
        took.append(time.thread_time() - began)
    return min(took)
