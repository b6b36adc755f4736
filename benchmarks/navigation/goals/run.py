"""Drives: a simulated robot is sent to several goals in a map with pedestrians; all drives, kept in a file."""

import json
import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.harness.parallel_runs import run_all
from benchmarks.navigation.goals.clone import MODEL, InProcessClone
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.maps.grid import GridMap
from ppaas.messages.actionlib_msgs import Status
from ppaas.robot_model.known_models import robot_model
from robots.demo.contact_referee import Referee
from robots.sim.courses import GoalRules
from robots.sim.driver import FixedRate, SensorRates
from robots.sim.robot import SimulatedRobot
from robots.sim.shortest_paths import ShortestPaths
from robots.sim.world import World

EPOCH = 1_000.0
"""Stamp at the start [s]; a stamp of zero would mean the latest time."""
NEAREST = 5.0
"""Smallest distance to a goal if the map is large enough [m]."""
ROOM = 3.0
"""Smallest distance of pedestrians from the robot at the start [m]."""
SLOWEST, PATIENCE = 0.1, 120.0
"""The time limit of a goal is the length of the shortest path at this speed [m/s], plus this time [s]."""
THERE, TURNED = 0.5, math.radians(30.0)
"""Largest true distance and angle from a goal that counts as reached [m, rad]."""


@dataclass(frozen=True, slots=True)
class GoalsJob:
    """Settings of a drive.

    Parameters
    ----------
    name : str
        Name of the map.
    grid : GridMap
    people : int
        Number of pedestrians.
    goals : int
        Number of goals.
    controller : str
        Name of the local planner.
    parameters : dict
        Parameters of nodes and plug-ins, as in a robot's file.
    seed, drive : int
        All randomness depends on these alone.
    told : bool
        Whether the positions of people are published to the robot.
    """

    name: str
    grid: GridMap
    people: int
    goals: int
    controller: str
    parameters: dict[str, Any]
    seed: int
    drive: int
    told: bool = False


@dataclass(frozen=True, slots=True)
class GoalsResult:
    """Result of a goal.

    Parameters
    ----------
    map : str
    drive, goal : int
        Numbers of the drive and of the goal.
    outcome : str
        ``reached``, or the reason why it was not.
    seconds, metres : float
        Duration and driven distance.
    recoveries : int
        Number of recoveries.
    walls, caused, suffered : int
        Contacts with walls, and with people, caused by the robot or not.
    nearest : float
        Smallest distance to a person while the robot moved [m].
    """

    map: str
    drive: int
    goal: int
    outcome: str
    seconds: float
    metres: float
    recoveries: int
    walls: int
    caused: int
    suffered: int
    nearest: float

    @property
    def reached(self) -> bool:
        """Whether the robot reached the goal."""
        return self.outcome == "reached"


class Trip:
    """The simulated world, the robot, its clone, and the referee.

    Parameters
    ----------
    job : GoalsJob
    """

    def __init__(self, job: GoalsJob) -> None:
        rng = np.random.default_rng((job.seed, job.drive))
        self.ways = ShortestPaths(job.grid, GoalRules().clearance, rng)
        start = self.ways.anywhere()
        self.world = World(job.grid, int(rng.integers(1 << 30)), epoch=EPOCH)
        self.robot: SimulatedRobot = self.world.add_robot(start)
        walkways = ShortestPaths(job.grid, self.world.pedestrian_model.clearance, rng)
        for _ in range(job.people):
            self.world.add_pedestrian(walkways, walkways.away_from(start, ROOM))
        layers = build_layers(job.grid, robot_radius=robot_model(MODEL).robot_radius)
        parameters = {**job.parameters, "amcl": {"seed": job.drive, **job.parameters.get("amcl", {})}}
        self.clone = InProcessClone(layers, start, job.controller, parameters, self.world.stamp)
        self.referee = Referee(self.world, self.robot)
        self._told = job.told
        rates = SensorRates()
        self._odometry, self._scan = FixedRate(rates.odom, 0.0), FixedRate(rates.scan, 0.0)

    def step(self) -> None:
        """Simulate a step: pass the robot's sensor data to the clone, and the clone's command to the wheels."""
        now = self.world.time()
        if self._odometry.take(now):
            self.clone.odometry(self.robot.odometry())
        if self._scan.take(now):
            self.clone.scan(self.robot.scan())
            if self._told:
                ways = np.array([pedestrian.body.velocity for pedestrian in self.world.pedestrians]).reshape(-1, 2)
                self.clone.people(self.world.people(), ways)
        command = self.clone.command()
        if command is not None:
            self.robot.command(command)
        self.world.step()
        self.referee.look()


Watch = Callable[[Trip], None]


def drive(job: GoalsJob, watch: Watch | None = None) -> list[GoalsResult]:
    """Simulate the drive to all goals, faster than real time.

    Parameters
    ----------
    job : GoalsJob
    watch : callable, optional
        Called with the trip after each step.
    """
    trip = Trip(job)
    return [_send(trip, job, number, watch) for number in range(job.goals)]


def _send(trip: Trip, job: GoalsJob, number: int, watch: Watch | None) -> GoalsResult:
    here = trip.ways.nearest(trip.robot.base.pose)
    goal = trip.ways.away_from(here, NEAREST)
    points = trip.ways.between(here, goal)
    limit = PATIENCE + float(np.hypot(*np.diff(points, axis=0).T).sum()) / SLOWEST
    began, clone = trip.world.time(), trip.clone
    touches, recovered, driven = trip.referee.begin(), clone.recoveries, trip.robot.base.travelled
    clone.send_to(goal)
    while clone.end is None and trip.world.time() - began < limit:
        trip.step()
        if watch is not None:
            watch(trip)
    outcome = _outcome(trip, goal)
    if clone.end is None:
        clone.cancel()
    return GoalsResult(
        job.name, job.drive, number, outcome, trip.world.time() - began,
        trip.robot.base.travelled - driven, clone.recoveries - recovered,
        touches.walls, touches.caused, touches.suffered, touches.nearest,
    )  # fmt: skip


def _outcome(trip: Trip, goal: Pose2D) -> str:
    end, pose = trip.clone.end, trip.robot.base.pose
    if end is None:
        return "timeout"
    if end.status != Status.SUCCEEDED:
        return f"aborted: {end.text}"
    away, turn = pose.distance_to(goal), abs(wrap_angle(pose.theta - goal.theta))
    there = away <= THERE and turn <= TURNED
    return "reached" if there else f"elsewhere: {away:.2f} m and {math.degrees(turn):.0f}° off"


# -- results of drives in a file, so that an interrupted bench continues where it stopped ------------------------------


def read(path: Path) -> Mapping[str, list[GoalsResult]]:
    """Return the stored results by `key`; empty if the file does not exist.

    Raises
    ------
    InvalidInput
        The file cannot be read, or its content is invalid.
    """
    try:
        lines = path.read_text().splitlines() if path.exists() else []
        rows = [json.loads(line) for line in lines]
        return {row["job"]: [GoalsResult(**each) for each in row["results"]] for row in rows}
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise InvalidInput(f"{path} is not a file of 'ppaas bench goals --keep': {error}; name another file") from error


def append(path: Path, job: GoalsJob, results: list[GoalsResult]) -> None:
    """Append the results of a drive; several processes may append at once, since each line is one write."""
    line = json.dumps({"job": key(job), "results": [asdict(result) for result in results]})
    with path.open("a") as file:
        file.write(line + "\n")


def key(job: GoalsJob) -> str:
    """Return the key of a drive: all of its settings except the cells of the map."""
    told = (job.name, job.people, job.goals, job.controller, job.parameters, job.seed, job.drive, job.told)
    return json.dumps(told, sort_keys=True)


# -- all drives of the goals bench, in parallel processes, and their summary -------------------------------------------


def measure(
    jobs: Sequence[GoalsJob], processes: int, done: Callable[[], None], keep: Path | None = None
) -> list[GoalsResult]:
    """Simulate all drives; return the result of each goal, in the order of the jobs.

    Parameters
    ----------
    jobs : sequence of GoalsJob
    processes : int
    done : callable
        Called after each drive.
    keep : Path, optional
        File of results; drives that it contains are not repeated.

    Raises
    ------
    InvalidInput
        The file is not a file of results.
    """
    if keep is None:
        return [result for results in run_all(drive, jobs, processes, done) for result in results]
    known = read(keep)
    left = [job for job in jobs if key(job) not in known]
    for _ in range(len(jobs) - len(left)):
        done()
    run_all(partial(_drive_and_keep, keep), left, processes, done)
    known = read(keep)
    return [result for job in jobs for result in known[key(job)]]


def _drive_and_keep(path: Path, job: GoalsJob) -> None:
    append(path, job, drive(job))


def summary(results: Sequence[GoalsResult]) -> dict[str, Any]:
    """Return the summary of all goals; times are means over the reached goals."""
    times = [result.seconds for result in results if result.reached]
    nearest = min(result.nearest for result in results)
    return {
        "goals": len(results),
        "reached": len(times),
        "collisions": sum(result.walls + result.caused + result.suffered for result in results),
        "caused": sum(result.walls + result.caused for result in results),
        "walls": sum(result.walls for result in results),
        "touched_by_people": sum(result.suffered for result in results),
        "mean_seconds": round(float(np.mean(times)), 1) if times else None,
        "metres": round(sum(result.metres for result in results), 1),
        "recoveries": sum(result.recoveries for result in results),
        "nearest_m": round(nearest, 3) if np.isfinite(nearest) else None,
        "failures": dict(Counter(result.outcome for result in results if not result.reached)),
    }
