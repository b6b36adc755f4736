"""Traffic: simulated Turtlebots with real clones in a hall, led by the traffic node of their map, in simulated time."""

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from random import Random

import numpy as np

from benchmarks.harness.figures import Figure
from benchmarks.harness.halls import LANES, distance_figure, goal_in, largest_part, zones_of_hall
from benchmarks.navigation.goals.clone import MODEL, ClonedRobot, InProcessClone
from ppaas.clone.plugins import DEFAULT_CONTROLLER
from ppaas.clone.traffic import build_traffic, roadmaps_of
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import InvalidInput
from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.geometry import Pose2D
from ppaas.maps.generate import office, warehouse
from ppaas.maps.grid import GridMap
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.fleet.traffic import TrafficGrants, TrafficReport
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance, PoseWithCovarianceStamped
from ppaas.messages.ppaas_msgs import RobotState, RobotStates
from ppaas.nodes import topics
from ppaas.nodes.base import Payload
from ppaas.nodes.frames import MAP
from ppaas.nodes.graph import Graph
from ppaas.nodes.jobs import run_inline
from ppaas.robot_model.known_models import robot_model
from ppaas.traffic.settings import TrafficParameters
from ppaas.traffic.taking_part import TRAFFIC
from ppaas.zones.zone import NO_ZONES, ZoneSet
from robots.sim.driver import FixedRate
from robots.sim.world import World

EPOCH = 1_000_000.0
"""Stamp at the start [s]; a stamp of zero would mean the latest time."""

DELAY = 0.1
"""Time that a message between a clone and the traffic node takes [s]."""


SHARE_RATE = 5.0
"""Rate at which robots share their positions [Hz]."""


class SimulatedTrafficRobot(ClonedRobot):
    """One robot: its simulated body, and its clone.

    Attributes
    ----------
    arrived, failed : int
        Number of goals that it reached, and that ended otherwise.
    goal_since : float
        Time at which it got its goal [s].
    misses : list of float
        Distance from each goal when it reported it as reached [m].
    """

    def __init__(self, world: World, number: int, layers: MapLayers, *, obeys: bool) -> None:
        self.id = f"tb{number}"
        body = world.robots[number]
        parameters = {"amcl": {"seed": number}, **({TRAFFIC: {}} if obeys else {})}
        clone = InProcessClone(layers, body.base.pose, DEFAULT_CONTROLLER, parameters, world.stamp, robot=self.id)
        super().__init__(world, body, clone)
        self.goal: Pose2D | None = None
        self.goal_since = 0.0
        self.arrived = self.failed = 0
        self.reasons: list[str] = []
        self.misses: list[float] = []
        self._pose = PoseWithCovarianceStamped(Header(frame_id=MAP), PoseWithCovariance(Pose.of(self.body.base.pose)))
        self._granted = False
        for topic in (topics.AMCL_POSE, topics.TRAFFIC_REPORT) if obeys else (topics.AMCL_POSE,):
            self.clone.graph.tap(topic.name, self._hear)

    def send_to(self, goal: Pose2D) -> None:
        """Send the robot to a pose."""
        self.goal, self.goal_since = goal, self._world.time()
        self.clone.send_to(goal)

    def _hear(self, _topic: str, message: Payload) -> None:
        match message:
            case PoseWithCovarianceStamped():
                self._pose = message
            case TrafficReport():
                self._granted = not message.free and not message.stray

    def state(self) -> RobotState:
        """Return what the robot shares with the others."""
        twist = self.body.odometry().twist.twist
        return RobotState(self._pose.header, self._pose.pose, twist, self.body.base.model.radius, self._granted)

    def step(self) -> None:
        """Simulate sensors and wheels, and note the end of a goal."""
        super().step()
        end, goal = self.clone.end, self.goal
        if goal is not None and end is not None:
            self.goal = None
            if end.status is Status.SUCCEEDED:
                self.arrived += 1
                self.misses.append(goal.distance_to(self.body.base.pose))
            else:
                self.failed += 1
                self.reasons.append(end.text)


@dataclass
class RunOutcome:
    """What has become of a run.

    Parameters
    ----------
    goals, failed : int
        Number of goals reached, and ended otherwise.
    contacts : int
        Number of contacts of robots with each other.
    walls : int
        Number of contacts with walls.
    nearest : float
        Smallest gap between two robots [m].
    longest : float
        Longest time for which a goal was open [s].
    mean : float
        Mean time of a goal [s].
    misses : list of float
        Distances of robots from the goals that they reached [m].
    """

    goals: int
    failed: int
    contacts: int
    walls: int
    nearest: float
    longest: float
    mean: float
    misses: list[float]


class TrafficScene:
    """World, robots and traffic node, step by step.

    Parameters
    ----------
    grid : GridMap
    robots : int
    seed : int
    obeys : bool
        Whether robots take part in the traffic; otherwise each drives around the others.
    zones : ZoneSet
        Zones of the map.
    """

    def __init__(self, grid: GridMap, robots: int, seed: int, *, obeys: bool = True, zones: ZoneSet = NO_ZONES) -> None:
        self.rng = Random(seed)
        self.world = World(grid, seed, epoch=EPOCH)
        radius = robot_model(MODEL).robot_radius
        self.layers = build_layers(grid, robot_radius=radius, zones=zones)
        self.roadmap: MetricRoadmap = roadmaps_of(self.layers)((radius,), TrafficParameters())
        self.cells = largest_part(self.roadmap.roadmap)
        for cell in self.rng.sample(self.cells, robots):
            self.world.add_robot(Pose2D(*self.roadmap.centre(cell), self.rng.uniform(-3.0, 3.0)))
        self.robots = [SimulatedTrafficRobot(self.world, number, self.layers, obeys=obeys) for number in range(robots)]
        self._names = {robot.id: robot for robot in self.robots}
        self._post: deque[tuple[float, TrafficReport | TrafficGrants]] = deque()
        self.node: Graph | None = None
        for robot in self.robots if obeys else ():
            robot.clone.graph.tap(topics.TRAFFIC_REPORT.name, self._send)
        if obeys:
            self.start_node()
        self.nearest, self.longest, self._times = 9.0, 0.0, 0.0
        self._share = FixedRate(SHARE_RATE, 0.0)

    def start_node(self) -> None:
        """Start a traffic node that knows nothing of any before it."""
        self.node = Graph(run_inline, self.world.stamp, self.world.stamp)
        build_traffic(self.node, self.layers)
        self.node.tap(topics.TRAFFIC_GRANTS.name, self._send)

    def _send(self, _topic: str, message: Payload) -> None:
        if isinstance(message, TrafficReport | TrafficGrants):
            self._post.append((self.world.time() + DELAY, message))

    def _deliver(self) -> None:
        while self._post and self._post[0][0] <= self.world.time():
            message = self._post.popleft()[1]
            if isinstance(message, TrafficGrants):
                self._names[message.robot].clone.graph.inject(topics.TRAFFIC_GRANTS.name, message)
            elif self.node is not None:
                self.node.inject(topics.TRAFFIC_REPORT.name, message)
        if self.node is not None:
            self.node.run_due()

    def step(self, *, again: bool = True) -> None:
        """Simulate a step of the world; robots that have no goal get one if ``again``."""
        for robot in self.robots:
            if again and robot.goal is None:
                place = goal_in(self.rng.choice(self.cells), self.roadmap, robot.body.base.model.radius, self.rng)
                robot.send_to(Pose2D(*place, self.rng.uniform(-3.0, 3.0)))
            before = robot.arrived
            robot.step()
            if robot.arrived > before:
                self._times += self.world.time() - robot.goal_since
            if robot.goal is not None:
                self.longest = max(self.longest, self.world.time() - robot.goal_since)
        if self._share.take(self.world.time()):
            self._share_poses()
        self._deliver()
        self.world.step()
        self._measure()

    def _share_poses(self) -> None:
        """Tell each robot where the others are, as the fleet bridges of their containers do."""
        states = [robot.state() for robot in self.robots]
        header = Header(stamp=Time.of(self.world.stamp()), frame_id=MAP)
        for number, robot in enumerate(self.robots):
            others = [state for other, state in enumerate(states) if other != number]
            robot.clone.graph.inject(
                topics.ROBOTS.name,
                RobotStates(
                    header, [each.pose.pose for each in others], [each.twist for each in others],
                    [each.radius for each in others], [each.granted for each in others],
                ),
            )  # fmt: skip

    def _measure(self) -> None:
        places = np.array([tuple(robot.body.base.body.position) for robot in self.robots])
        apart = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1)) + 9.0 * np.eye(len(places))
        self.nearest = min(self.nearest, float(apart.min()) - 2.0 * self.robots[0].body.base.model.radius)

    @property
    def reasons(self) -> list[str]:
        """Texts of goals that were not reached, each once."""
        return sorted({reason for robot in self.robots for reason in robot.reasons})

    def outcome(self) -> RunOutcome:
        """Return what has become of it so far."""
        goals = sum(robot.arrived for robot in self.robots)
        contacts = self.world.contacts
        return RunOutcome(
            goals, sum(robot.failed for robot in self.robots), contacts.robot_contacts.total() // 2,
            contacts.wall_contacts.total(), round(self.nearest, 3), round(self.longest, 1),
            round(self._times / max(goals, 1), 1), [miss for robot in self.robots for miss in robot.misses],
        )  # fmt: skip


# -- robots with real clones in simulated halls ------------------------------------------------------------------------

PART = "traffic"

HALLS: dict[str, Callable[[int], GridMap]] = {
    "warehouse": warehouse,
    "office": office,
    "large-office": partial(office, width=48.0, height=32.0),
    LANES: partial(warehouse, width=40.0),
}
"""Halls that are made up, by name."""

SHARE = 0.75
"""Least part of the goals of robots that are alone."""

ALONE = 6
"""Number of robots that are each alone, whose mean number of goals is the baseline: goals are drawn near and far."""

WAITS = 5.0
"""Largest ratio of the longest time of a goal to the mean."""


@dataclass(frozen=True, slots=True)
class TrafficCase:
    """Robots in a hall for some time.

    Parameters
    ----------
    hall : str
        Name of a hall of `HALLS`.
    robots : int
    seconds : float
        Simulated time [s].
    seed : int
    """

    hall: str
    robots: int
    seconds: float
    seed: int = 1

    def grid(self) -> GridMap:
        """Return the map of the hall."""
        return HALLS[self.hall](self.seed)


def case_of(words: list[str]) -> TrafficCase:
    """Return the case of the words on a command line: hall, robots, minutes, seed.

    Raises
    ------
    InvalidInput
        There is no such hall, or a number is not one.
    """
    hall, robots, minutes, seed = words
    if hall not in HALLS:
        raise InvalidInput(f"there is no hall {hall!r}; choose one of {', '.join(HALLS)}")
    try:
        return TrafficCase(hall, int(robots), 60.0 * float(minutes), int(seed))
    except ValueError as error:
        raise InvalidInput(f"robots, minutes and seed must be numbers: {error}") from error


def measure(case: TrafficCase) -> Iterator[Figure]:
    """Run robots by the traffic of their map, and some robots that are each alone."""
    grid = case.grid()
    scene = _run(TrafficScene(grid, case.robots, case.seed, zones=zones_of_hall(case.hall, grid)), case.seconds)
    seeds = range(case.seed, case.seed + ALONE)
    alone = sum(_run(TrafficScene(grid, 1, seed), case.seconds).outcome().goals for seed in seeds) / ALONE
    got, name = scene.outcome(), f"{case.hall}, {case.robots}, seed {case.seed}"
    share = got.goals / max(alone * case.robots, 1.0)
    yield Figure(PART, f"{name}: contacts of robots", got.contacts, "", limit=0.0, note=f"nearest {got.nearest:g} m")
    yield Figure(PART, f"{name}: contacts with walls", got.walls, "", limit=0.0)
    yield Figure(
        PART, f"{name}: goals", got.goals, "", limit=SHARE * alone * case.robots, floor=True,
        note=f"{share:.0%} of {case.robots} robots that are each alone ({alone:g} goals each, by {ALONE})",
    )  # fmt: skip
    yield Figure(PART, f"{name}: goals that ended otherwise", got.failed, "", limit=0.0, note="; ".join(scene.reasons))
    yield Figure(
        PART, f"{name}: longest open goal", got.longest, "s", limit=round(WAITS * got.mean, 1),
        note=f"mean of those reached {got.mean:g} s",
    )  # fmt: skip
    if got.misses:
        yield distance_figure(PART, name, got.misses)


def _run(scene: TrafficScene, seconds: float) -> TrafficScene:
    while scene.world.time() < seconds:
        scene.step()
    return scene
