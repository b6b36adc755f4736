"""Drives by what was imported: robot files and maps, in a simulated world and the clone in this process."""

from collections.abc import Mapping
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from benchmarks.navigation.goals.clone import ClonedRobot, CloneGoalEnd, InProcessClone
from ppaas.clone.plugins import DEFAULT_CONTROLLER, DEFAULT_PLANNER
from ppaas.clone.robot_body import costmap_parameters, robot_body
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import PPaaSError
from ppaas.fleet.lane_drawing import Network, lines_in, network_of
from ppaas.geometry import Pose2D
from ppaas.imports.maps.common.imported_map import ImportedMap, grid_around
from ppaas.maps.generate import office
from ppaas.maps.grid import FREE, OCCUPIED, GridMap
from ppaas.maps.new_map import new_map_id
from ppaas.messages.actionlib_msgs import Status
from ppaas.polygons import Points
from ppaas.zones.zone import ZoneSet
from robots.sim.courses import GoalRules
from robots.sim.shortest_paths import ShortestPaths
from robots.sim.world import World

EPOCH = 1_000.0
"""Stamp at the start [s]; a stamp of zero would mean the latest time."""

NEAREST, MARGIN = 4.0, 0.15
"""Smallest distance to the goal, and of the way from walls beyond the robot's radius [m]."""

LIMIT, THERE = 180.0, 0.7
"""Longest simulated time of a drive [s], and largest true distance from the goal at its end [m]."""

LONGEST, ROOM, CELL = 30.0, 3.0, 0.05
"""Longest way along lanes, free space around them, and edge of the cells of their map [m]."""

MODEL = "turtlebot2"


def drive(file: Mapping[str, Any], grid: GridMap | None = None, seed: int = 0) -> str:
    """Let a robot drive to a goal; return ``drove 7.3 m in 24 s``, or why it did not.

    Parameters
    ----------
    file : mapping
        Robot file. The simulated robot is a Turtlebot 2, whatever model the file names; its clone is the file's.
    grid : GridMap, optional
        Map of the world; default: a generated office.
    seed : int
        Start, goal and noise depend on it alone.
    """
    try:
        return _drive(file, office(seed) if grid is None else grid, seed)
    except PPaaSError as error:
        return f"no: {error.slug}: {error}"


def drive_on_imported(imported: ImportedMap) -> str:
    """Let a robot drive to a goal on an imported map; return as `drive`."""
    return drive({"map": "imported"}, imported.grid)


def drive_lanes(zones: ZoneSet) -> str:
    """Let a robot drive along lanes, to the farthest place within reach; return as `drive`, or that there are none."""
    lanes = lines_in(zones.zones)
    if not lanes:
        return "has no lanes to drive along"
    try:
        route = _route(network_of(lanes))
        return _drive_route(route) if len(route) > 1 else "no: no place can be reached from another"
    except PPaaSError as error:
        return f"no: {error.slug}: {error}"


def _drive(file: Mapping[str, Any], grid: GridMap, seed: int) -> str:
    parameters = dict(file.get("parameters", {}))
    radius = robot_body(MODEL, None, parameters).robot_radius
    ways = ShortestPaths(grid, max(GoalRules().clearance, radius + MARGIN), np.random.default_rng(seed))
    start = ways.anywhere()
    goal = ways.away_from(start, NEAREST)
    simulation = _Simulation(file, grid, start, radius, seed)
    end = simulation.drive_to(goal)
    away = simulation.pose.distance_to(goal)
    if end.status != Status.SUCCEEDED or away > THERE:
        return f"no: {end.text or end.status.name.lower()}, {away:.1f} m away"
    return simulation.driven


def _route(network: Network) -> Points:
    """Return the places along the shortest way to the farthest place that is at most `LONGEST` away from a place.

    If all places are farther away, the way leads to the nearest one, and ends after `LONGEST`.
    """
    begins, ends = np.array(list(network.names)).T
    lengths = np.hypot(*(network.places[ends] - network.places[begins]).T)
    count = len(network.places)
    graph = csr_matrix((lengths, (begins, ends)), (count, count))
    start = int(begins[np.bincount(begins, minlength=count)[begins].argmax()])
    away, before = dijkstra(graph, indices=start, return_predecessors=True)
    place = int(np.where(away <= LONGEST, away, -1.0).argmax())
    if place == start:
        return _to_nearest(network.places, start, np.where(away > 0.0, away, np.inf))
    route = [place]
    while place != start:
        place = int(before[place])
        route.append(place)
    return network.places[route[::-1]]


def _to_nearest(places: Points, start: int, away: NDArray[np.float64]) -> Points:
    """Return a way of `LONGEST` from a place towards the nearest one; the place alone if none can be reached."""
    nearest = int(away.argmin())
    if not np.isfinite(away[nearest]):
        return places[[start]]
    way = places[nearest] - places[start]
    return np.array([places[start], places[start] + way * (LONGEST / float(np.hypot(*way)))])


def _drive_route(route: Points) -> str:
    info = grid_around(route.min(axis=0) - ROOM, route.max(axis=0) + ROOM, CELL)
    cells = np.full((info.height, info.width), FREE, np.int8)
    cells[[0, -1]] = cells[:, [0, -1]] = OCCUPIED
    steps = np.diff(route, axis=0)
    headings = np.arctan2(steps[:, 1], steps[:, 0])
    places = [Pose2D(*pose) for pose in np.column_stack((route, np.append(headings, headings[-1]))).tolist()]
    simulation = _Simulation({"map": "lanes"}, GridMap(cells, info), places[0], robot_body(MODEL).robot_radius, 0)
    for place in places[1:]:
        end = simulation.drive_to(place)
        if end.status != Status.SUCCEEDED:
            return f"no: {end.text or end.status.name.lower()}, at {place.x:.1f}, {place.y:.1f}"
    return simulation.driven


class _Simulation:
    """World with one robot and its clone, in this process."""

    def __init__(self, file: Mapping[str, Any], grid: GridMap, start: Pose2D, radius: float, seed: int) -> None:
        parameters = dict(file.get("parameters", {}))
        costs = msgspec.structs.asdict(costmap_parameters(parameters).costs)
        self._start = start if new_map_id(file.get("map", "")) is not None else None
        self._world = World(grid, seed, epoch=EPOCH)
        self._body = self._world.add_robot(start)
        self._clone = InProcessClone(
            None if self._start else build_layers(grid, robot_radius=radius, **costs),
            Pose2D(0.0, 0.0, 0.0) if self._start else start,
            file.get("base_local_planner", DEFAULT_CONTROLLER),
            parameters,
            self._world.stamp,
            planner=file.get("base_global_planner", DEFAULT_PLANNER),
        )
        self._robot = ClonedRobot(self._world, self._body, self._clone)

    def drive_to(self, goal: Pose2D) -> CloneGoalEnd:
        """Drive to a goal in the frame of the world."""
        self._clone.send_to(goal if self._start is None else self._start.inverse() @ goal)
        until = self._world.time() + LIMIT
        while self._clone.end is None and self._world.time() < until:
            self._robot.step()
            self._world.step()
        return self._clone.end or CloneGoalEnd(Status.ABORTED, f"on its way after {LIMIT:g} s")

    @property
    def pose(self) -> Pose2D:
        """True pose of the robot."""
        return self._body.base.pose

    @property
    def driven(self) -> str:
        """Distance and time that the robot has driven."""
        return f"drove {self._body.base.travelled:.1f} m in {self._world.time():.0f} s"
