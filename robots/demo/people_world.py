"""World of robots and people: an office or a warehouse with furniture, and which people a robot has in view."""

import math
from collections.abc import Callable, Sequence
from itertools import cycle, islice
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D, wrap_angle
from ppaas.maps.grid import FREE, GridInfo, GridMap
from ppaas.maps.raycast import cast_rays
from ppaas.messages.people_coordination import SensorView
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
from robots.sim.laser import Discs, cast_at_discs
from robots.sim.pedestrian import PedestrianModel
from robots.sim.robot import SimulatedRobotModel
from robots.sim.shortest_paths import TRIES, ShortestPaths
from robots.sim.world import World

Floats = NDArray[np.float64]

# -- true visibility of people -----------------------------------------------------------------------------------------

TORSO, THIN = 0.2, 0.12
"""Radius of a torso as seen from above, and half of its depth: a person who turns aside hides no more [m]."""

RAYS = 9
"""Number of rays from a sensor to a torso, spread evenly over its width."""

BEYOND, PERHAPS = 1.5, 0.4
"""Multiple of the range up to which people may be seen, and the largest share of those torsos: below half."""


class Occluders(NamedTuple):
    """Objects that hide people.

    Parameters
    ----------
    occupied : (height, width) bool array
        Cells of walls.
    info : GridInfo
        Geometry of the cells.
    discs : tuple of Discs
        Other objects that are as high as a torso, from above.
    """

    occupied: NDArray[np.bool_]
    info: GridInfo
    discs: tuple[Discs, ...] = ()


def visible_shares(
    surroundings: Occluders, robot: Pose2D, views: Sequence[SensorView], people: Floats, radius: float = TORSO
) -> Floats:
    """Return the share of each torso that a robot has in view, the largest of its sensors.

    A ray to a point of a torso counts if it is within the field of view and nothing else stops it before the torso. A
    torso whose centre is nearer than the sensor's range, or up to `BEYOND` times its end, has at most share `PERHAPS`:
    detectors find some of these, too. One that is farther away has share 0. A torso that another one hides has up to
    share `PERHAPS`, too, if its sides are in view unless the person in front shows the whole breadth of the shoulders.

    Parameters
    ----------
    surroundings : Occluders
    robot : Pose2D
        True pose of the robot.
    views : sequence of SensorView
        Views of its sensors.
    people : (n, 2) array
        True positions of all people [m].
    radius : float
        Radius of a torso [m].

    Returns
    -------
    (n,) array
        Shares from 0 to 1.
    """
    shares = np.zeros(len(people))
    for view in views:
        sensor = robot @ Pose2D(view.x, view.y, view.yaw)
        distances = np.hypot(*(people - sensor[:2]).T)
        for person in np.flatnonzero(distances <= BEYOND * view.range_max).tolist():
            others, hide = np.delete(people, person, axis=0), surroundings.discs
            before = surroundings._replace(discs=((others, radius), *hide))
            share = _share(before, sensor, view, people[person], radius)
            if share < PERHAPS:
                before = surroundings._replace(discs=((others, THIN), *hide))
                share = max(share, min(_share(before, sensor, view, people[person], radius), PERHAPS))
            in_range = view.range_min <= distances[person] <= view.range_max
            shares[person] = max(shares[person], share if in_range else min(share, PERHAPS))
    return shares


def _share(before: Occluders, sensor: Pose2D, view: SensorView, person: Floats, radius: float) -> float:
    """Return the share of one torso that a sensor at a pose has in view."""
    right, up = (person - sensor[:2]).tolist()
    distance = math.hypot(right, up)
    if distance <= radius:
        return 0.0
    half = math.asin(radius / distance) * (1.0 - 1.0 / RAYS)
    angles = wrap_angle(math.atan2(up, right) - sensor.theta) + np.linspace(-half, half, RAYS)
    angles = angles[np.abs(angles) <= 0.5 * view.field_of_view]
    if not len(angles):
        return 0.0
    reach = distance - radius
    ranges = cast_rays(before.occupied, before.info, sensor, angles, distance + radius)
    for centres, size in before.discs:
        ranges = np.minimum(ranges, cast_at_discs(sensor, angles, centres, size))
    return float(np.count_nonzero(ranges > reach) / RAYS)


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
    surroundings : Occluders
        Objects that hide people.
    ways : ShortestPaths
        Places for robots.
    """

    world: World
    keepout: GridMap
    surroundings: Occluders
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


def _surroundings(world: World) -> Occluders:
    hiding = [(piece.pose[:2], HIDING[piece.kind]) for piece in world.furniture if piece.kind in HIDING]
    discs = tuple((np.array([place]), radius) for place, radius in hiding)
    return Occluders(world.occupied, world.grid.info, discs)


# -- people ------------------------------------------------------------------------------------------------------------


def _populate(
    world: World, paths: ShortestPaths, habits: Sequence[str], robots: Sequence[Pose2D], rng: np.random.Generator
) -> None:
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
