"""Part ``legs`` of ``ppaas bench people``: recall, precision and time of the leg detector.

A robot wanders through offices with people who stand, walk and talk among furniture that is not in its map.
"""

import math
import statistics
import time
from collections import Counter
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness.figures import Figure, PartResult
from benchmarks.people.options import PeopleOptions
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.obstacle_layer import LaserReading
from ppaas.geometry import Pose2D
from ppaas.maps.generate import office
from ppaas.messages.geometry_msgs import Twist, Vector3
from ppaas.messages.people_coordination import SensorView
from ppaas.perception.legs.detector import LegDetection, LegDetector, MapInFrame
from ppaas.perception.legs.parameters import LegDetectorParameters
from robots.demo.people_world import PeopleWorld, build_world, present, visible_shares
from robots.sim.robot import SimulatedRobot

Floats = NDArray[np.float64]

PART = "legs"

PEOPLE, OFFICE = 14, (24.0, 16.0)
"""Number of people, and size of the office [m]."""

OFFICES, SECONDS = 4, 100.0
"""Number of offices, and simulated time in each [s]; one office if few samples are taken."""

PERIOD, BEGIN = 0.1, 1.0
"""Time between two scans, and time after which they count [s]."""

VIEW = SensorView(0.0, 0.0, 0.0, 2.0 * math.pi, 0.4, 4.0)
"""View in which a person who is not detected counts as missed."""

NEAR = 0.5
"""Distance within which a detection is of a person [m]."""

MAP_ERROR = 0.02
"""Standard deviation of the position in the map along x and y [m]."""

AWAY = 1e3
"""Coordinate of people who are not on the map [m]."""


class Sample(NamedTuple):
    """People and detections of one scan.

    Parameters
    ----------
    robot : Pose2D
    people : (n, 2) array
        All people [m].
    visible : (n,) bool array
        Those who stand or walk in view, and are half visible or more.
    found : list of LegDetection
    seconds : float
        Time of the detector [s].
    """

    robot: Pose2D
    people: Floats
    visible: NDArray[np.bool_]
    found: list[LegDetection]
    seconds: float


def measure(options: PeopleOptions) -> PartResult:
    """Return recall by distance, precision, position error and time of a scan."""
    counts: Counter[str] = Counter()
    errors, seconds = list[float](), list[float]()
    for seed in range(1 if options.quick else OFFICES):
        rng = np.random.default_rng(options.seed + seed)
        stage = build_world(office(options.seed + seed, *OFFICE), 1, PEOPLE, None, rng)
        for sample in _samples(stage, rng):
            seconds.append(sample.seconds)
            errors += _count(sample, counts)
    rows = [
        {"distance": f"{far}–{far + 1} m", "people": f"{counts[f'seen {far}'] + counts[f'missed {far}']}",
         "recall": f"{_recall(counts, far):.3f}"}
        for far in range(4)
    ]  # fmt: skip
    begins = counts["begins"] / max(counts["begins"] + counts["begins wrongly"], 1)
    note = f"{len(seconds)} scans in offices with {PEOPLE} people"
    figures = [
        Figure(PART, "recall up to 4 m", round(_recall(counts), 4), "", note=note),
        Figure(PART, "precision of detections that begin tracks", round(begins, 4), ""),
        Figure(PART, "position error", round(statistics.median(errors), 4) if errors else math.nan, "m"),
        Figure(PART, "time of a scan", round(1e3 * statistics.median(seconds), 2), "ms", note="CPU time"),
    ]
    return PartResult(figures, rows, [dict(counts)])


def _recall(counts: Counter[str], *distances: int) -> float:
    """Return the share of people at these distances who are detected; by default at all."""
    each = distances or range(4)
    seen, missed = (sum(counts[f"{kind} {far}"] for far in each) for kind in ("seen", "missed"))
    return seen / max(seen + missed, 1)


def _count(sample: Sample, counts: Counter[str]) -> list[float]:
    """Count detected people and wrong detections; return the position errors [m]."""
    places, errors = np.array([(each.x, each.y) for each in sample.found]).reshape(-1, 2), []
    for person in sample.people[sample.visible]:
        far = int(math.dist(person, sample.robot[:2]))
        error = float(np.min(np.hypot(*(places - person).T), initial=math.inf))
        counts[f"{'seen' if error < NEAR else 'missed'} {far}"] += 1
        errors += [error] if error < NEAR else []
    for each, place in zip(sample.found, places, strict=True):
        if each.may_begin:
            right = np.min(np.hypot(*(sample.people - place).T), initial=math.inf) < NEAR + 0.1
            counts["begins" if right else "begins wrongly"] += 1
    return errors


def _samples(stage: PeopleWorld, rng: np.random.Generator) -> Iterator[Sample]:
    world, detector = stage.world, LegDetector(LegDetectorParameters())
    robot, layers, turn = world.robots[0], build_layers(world.grid, robot_radius=0.18), 0.0
    every = round(PERIOD / world.dt)
    while world.time() < SECONDS:
        if world.steps % every == 0:
            scan, pose = robot.scan(), robot.base.pose
            reading = LaserReading.of(scan, pose)
            turn = _drive(robot, reading, turn, rng)
            off = rng.normal(0.0, MAP_ERROR, 2).tolist()
            start = time.process_time()
            found = detector.detect(reading, world.time(), MapInFrame(layers, Pose2D(*off)))
            seconds = time.process_time() - start
            if world.time() >= BEGIN:
                yield Sample(pose, *_people(stage, pose), found, seconds)
        world.step()


def _people(stage: PeopleWorld, robot: Pose2D) -> tuple[Floats, NDArray[np.bool_]]:
    """Return all people, and those whom the robot should detect: who sits has no legs apart."""
    people = np.nan_to_num(present(stage.world), nan=AWAY)
    visible = visible_shares(stage.surroundings, robot, [VIEW], people) >= 0.5
    return people, visible & ~np.array([person.sitting for person in stage.world.pedestrians], bool)


def _drive(robot: SimulatedRobot, reading: LaserReading, turn: float, rng: np.random.Generator) -> float:
    """Drive on, or turn away from what is near ahead; return the speed of the turn [rad/s]."""
    ahead = float(np.nanmin(reading.ranges[np.abs(reading.angles) < 0.6]))
    if ahead > 1.0:
        turn = 0.0
    elif ahead < 0.7 and turn == 0.0:
        turn = float(rng.choice([-0.8, 0.8]))
    robot.command(Twist(Vector3(0.0 if turn else 0.35), Vector3(z=turn)))
    return turn
