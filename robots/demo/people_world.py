"""World of robots and people: an office or a warehouse with furniture, people at work, and robots among them."""

import math
from collections.abc import Callable, Sequence
from itertools import cycle, islice
from typing import NamedTuple

import numpy as np

from ppaas.geometry import Pose2D
from ppaas.maps.grid import FREE, GridMap
from robots.demo.people_visibility import Surroundings
from robots.sim import actors
from robots.sim.actors import Script
from robots.sim.bodies.furniture import (
    CHAIR,
    COAT_STAND,
    COLUMN,
    Furniture,
    chair,
    coat_stand,
    column,
    furnished,
    table,
)
from robots.sim.courses import GoalRules, drivable
from robots.sim.depth.camera import DepthCameraModel
from robots.sim.pedestrian import PedestrianModel
from robots.sim.robot import SimulatedRobotModel
from robots.sim.shortest_paths import TRIES, ShortestPaths
from robots.sim.world import World

EPOCH = 1_000_000.0
"""Stamp at the start [s]; a stamp of zero would mean the latest time."""
APART = 1.5
"""Smallest distance between robots, from people to robots, and between pieces of furniture, at the start [m]."""
SPACE = 0.9
"""Smallest distance of furniture from walls, so that robots and people pass [m]."""
WALKERS = PedestrianModel(slowest=0.3, fastest=0.6)
"""Walking speeds below that of a Turtlebot, which is at most 0.65 m/s: no rule can follow a faster person."""
HABITS = ("wander", "talk", "talk", "sit", "wander", "wander", "come_and_go", "wander", "sit", "wander")
"""Habits of people, in turn."""
HIDING = {COAT_STAND: 0.22, COLUMN: 0.2}
"""Kinds of furniture that hide a torso, and their radii [m]."""
PLACES = 10
"""Number of places tried for a piece of furniture."""
CONNECTED = 0.8
"""Share of the area for robots that a piece of furniture must leave connected."""
TALKING = 1.0
"""Distance of two who talk [m]."""
SHORTEST_STAY, LONGEST_STAY = 30.0, 90.0
"""Shortest and longest time that people talk and sit [s]."""


class PeopleWorld(NamedTuple):
    """World of robots and people.

    Parameters
    ----------
    world : World
    keepout : GridMap
        Keep-out mask of the furniture.
    surroundings : Surroundings
        Objects that hide people.
    ways : ShortestPaths
        Places for robots.
    """

    world: World
    keepout: GridMap
    surroundings: Surroundings
    ways: ShortestPaths


def build_world(
    grid: GridMap, robots: int, people: int, camera: DepthCameraModel | None, rng: np.random.Generator
) -> PeopleWorld:
    """Return a world with furniture, robots and people.

    Parameters
    ----------
    grid : GridMap
    robots, people : int
        Numbers of robots and people.
    camera : DepthCameraModel, optional
        Depth camera of each robot.
    rng : numpy.random.Generator
        Source of all places.
    """
    world = World(grid, int(rng.integers(1 << 30)), epoch=EPOCH, bodies=True)
    world.pedestrian_model = WALKERS
    habits = list(islice(cycle(HABITS), people))
    pieces = _furniture(grid, habits.count("sit"), rng)
    for piece in pieces:
        world.add_furniture(piece)
    walls = furnished(grid, pieces)
    ways = ShortestPaths(walls, GoalRules().clearance, rng)
    taken: list[Pose2D] = []
    for _ in range(robots):
        taken.append(_apart(ways, taken))
        world.add_robot(taken[-1], SimulatedRobotModel(camera=camera))
    _populate(world, ShortestPaths(walls, WALKERS.clearance, rng), habits, taken, rng)
    mask = GridMap(np.where(walls.data != grid.data, walls.data, FREE).astype(np.int8), grid.info)
    return PeopleWorld(world, mask, _surroundings(world), ways)


def present(world: World) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Return the true positions (n, 2) of all people [m]; NaN for those who are not on the map."""
    away = np.array([not person.present for person in world.pedestrians], dtype=bool)
    return np.where(away[:, np.newaxis], np.nan, world.people())


def _furniture(grid: GridMap, sitters: int, rng: np.random.Generator) -> list[Furniture]:
    """Return furniture at random places that leave the map connected: chairs, tables, coat stands and a column."""
    free = ShortestPaths(grid, SPACE, rng)
    placed: list[Furniture] = []
    area = _connected_area(grid, placed)
    makers: list[Callable[[Pose2D], Furniture]] = [
        *[chair] * (sitters + 2),
        table,
        table,
        coat_stand,
        lambda pose: coat_stand(pose, hat=True),
        column,
    ]
    for make in makers:
        for _ in range(PLACES):
            piece = make(_apart(free, [other.pose for other in placed]))
            left = _connected_area(grid, [*placed, piece])
            if left >= CONNECTED * area:
                break
        # Those who sit need their chairs.
        if left >= CONNECTED * area or piece.kind == CHAIR:
            placed.append(piece)
            area = left
    return placed


def _connected_area(grid: GridMap, furniture: list[Furniture]) -> int:
    """Return the number of cells of the largest area in which robots can drive."""
    return int(np.count_nonzero(drivable(furnished(grid, furniture), GoalRules().clearance, np.random.default_rng(0))))


def _surroundings(world: World) -> Surroundings:
    hiding = [(piece.pose[:2], HIDING[piece.kind]) for piece in world.furniture if piece.kind in HIDING]
    discs = tuple((np.array([place]), radius) for place, radius in hiding)
    return Surroundings(world.occupied, world.grid.info, discs)


# -- people ------------------------------------------------------------------------------------------------------------


def _populate(
    world: World, paths: ShortestPaths, habits: Sequence[str], robots: Sequence[Pose2D], rng: np.random.Generator
) -> None:
    """Add people with habits, away from the robots."""
    free = iter([piece.pose for piece in world.furniture if piece.kind == CHAIR])
    partner: Pose2D | None = None
    for habit in habits:
        match habit:
            case "talk":
                partner, place = _meeting(paths, partner)
                script = _meets(place, paths, rng)
            case "sit":
                script = _sits(next(free), paths, rng)
            case "come_and_go":
                script = actors.come_and_go(paths.anywhere(), paths, rng)
            case _:
                script = actors.wander(paths, rng)
        world.add_actor(paths, _apart(paths, robots), script)


def _meeting(paths: ShortestPaths, partner: Pose2D | None) -> tuple[Pose2D | None, Pose2D]:
    """Return the place for the partner of one who talks, if that one is the first of two, and the own place."""
    if partner is not None:
        return None, partner
    for _ in range(TRIES):
        place = paths.anywhere()
        other = place @ Pose2D(TALKING, 0.0, math.pi)
        if paths.allows(other.x, other.y):
            break
    return other, place


def _meets(place: Pose2D, paths: ShortestPaths, rng: np.random.Generator) -> Script:
    """Walk about, and talk at a place again and again."""
    while True:
        yield from actors.talk(place, float(rng.uniform(SHORTEST_STAY, LONGEST_STAY)), iter(()))
        yield from islice(actors.wander(paths, rng), 4)


def _sits(seat: Pose2D, paths: ShortestPaths, rng: np.random.Generator) -> Script:
    """Walk about, and sit on a chair again and again."""
    while True:
        yield from actors.sit(seat, float(rng.uniform(SHORTEST_STAY, LONGEST_STAY)), iter(()))
        yield from islice(actors.wander(paths, rng), 4)


def _apart(ways: ShortestPaths, taken: Sequence[Pose2D]) -> Pose2D:
    """Return a random place at a distance from those that are taken, if one is found."""
    for _ in range(TRIES):
        pose = ways.anywhere()
        if all(pose.distance_to(other) >= APART for other in taken):
            break
    return pose
