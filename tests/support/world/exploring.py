"""An unknown place, of which a laser reveals what it sees, and a robot that jumps from frontier to frontier."""

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.build_layers import build_layers
from ppaas.exploration.approaches import Approach, Reach
from ppaas.exploration.choice import choose, same_frontier
from ppaas.exploration.frontiers import Frontier, find_frontiers
from ppaas.exploration.given_up import GivenUp
from ppaas.exploration.parameters import ChoiceParameters
from ppaas.geometry import Pose2D
from ppaas.maps.grid import FREE, OCCUPIED, OCCUPIED_THRESHOLD, UNKNOWN, GridMap
from ppaas.maps.raycast import cast_rays

BEAMS = np.linspace(-np.pi, np.pi, 720, endpoint=False)


class UnknownPlace:
    """World of which a map knows what a laser has seen."""

    def __init__(self, world: GridMap, reach: float = 8.0) -> None:
        self.world, self._reach = world, reach
        self._walls = world.data >= OCCUPIED_THRESHOLD
        self.known = GridMap(np.full(world.info.shape, UNKNOWN, np.int8), world.info)

    def see(self, pose: Pose2D) -> None:
        """Reveal what a laser sees from a pose."""
        info, data = self.world.info, self.known.data.copy()
        ranges = cast_rays(self._walls, info, pose, BEAMS, self._reach)
        along = np.arange(0.0, self._reach, 0.5 * info.resolution)
        directions = np.stack((np.cos(BEAMS + pose.theta), np.sin(BEAMS + pose.theta)), axis=1)
        points = np.array(pose[:2]) + along[:, None, None] * directions
        cells = info.to_cells(points[along[:, None] < np.minimum(ranges, self._reach)])
        data[cells[:, 0], cells[:, 1]] = FREE
        hit = np.isfinite(ranges)
        ends = info.to_cells(np.array(pose[:2]) + (ranges[hit, None] + 0.01) * directions[hit])
        data[ends[:, 0], ends[:, 1]] = OCCUPIED
        data[self._walls & (data == FREE)] = OCCUPIED
        self.known = GridMap(data, info)


def points_of(frontier: Frontier, grid: GridMap) -> NDArray[np.float64]:
    """Return the (n, 2) cells of a frontier, x, y [m]."""
    return grid.info.to_world(frontier.cells)


class Explorer:
    """Robot that explores an unknown place, a step of some metres at a time, always along its way."""

    def __init__(self, place: UnknownPlace, start: Pose2D, parameters: ChoiceParameters | None = None) -> None:
        self.place, self.pose = place, start
        self.parameters = parameters or ChoiceParameters()
        self.given_up = GivenUp()
        self.current: Approach | None = None
        self.travelled, self.targets = 0.0, 0
        place.see(start)

    def approaches(self) -> list[Approach]:
        grid = self.place.known
        found = find_frontiers(grid, self.parameters.min_frontier_size)
        left = [each for each in found if not self.given_up.covers(points_of(each, grid))]
        self.reach = Reach(grid, build_layers(grid).costmap, self.pose)
        return self.reach.approaches(left)

    def step(self, metres: float = 1.0) -> bool:
        """Drive some metres towards a frontier; return whether there is one."""
        approaches = self.approaches()
        points = [points_of(each.frontier, self.place.known) for each in approaches]
        before = None if self.current is None else same_frontier(approaches, points, self.current.seen, 1.5)
        chosen = choose(approaches, self.parameters, before)
        self.targets += chosen is not None and chosen is not before
        self.current = chosen
        if chosen is None:
            return False
        self._drive(chosen, metres)
        return True

    def _drive(self, chosen: Approach, metres: float) -> None:
        grid = self.place.known
        cell = grid.info.cell_of(chosen.pose.x, chosen.pose.y)
        assert cell is not None
        path = self.reach._field.path_from(cell)[::-1]
        steps = np.hypot(*np.diff(path, axis=0).T) * grid.info.resolution
        count = int(np.searchsorted(np.cumsum(steps), metres))
        self.travelled += float(steps[:count].sum())
        at = grid.info.to_world(path[min(count, len(path) - 1)])
        self.pose = Pose2D(float(at[0]), float(at[1]), chosen.pose.theta)
        self.place.see(self.pose)
        if count >= len(path) - 1:
            points = points_of(chosen.frontier, grid)
            self._after_arrival(points)

    def _after_arrival(self, points: NDArray[np.float64]) -> None:
        """Give a frontier up that is still there after the robot has seen it from its pose."""
        grid = self.place.known
        for frontier in find_frontiers(grid, self.parameters.min_frontier_size):
            cells = points_of(frontier, grid)
            seen = GivenUp()
            seen.add(points)
            if seen.covers(cells):
                self.given_up.add(cells)
