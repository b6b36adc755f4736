"""Local costmap: a rolling window around the robot with the map, obstacles seen by the laser, and people."""

import math
from collections.abc import Iterable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE, NO_INFORMATION
from ppaas.costmap.costmap import Costmap
from ppaas.costmap.filter_masks import raise_costs
from ppaas.costmap.inflation_layer import COST_SCALING_FACTOR, INFLATION_RADIUS, ROBOT_RADIUS, check_inflation, inflate
from ppaas.costmap.kernels.near_obstacles import are_few, lower_near, reach_in_cells
from ppaas.costmap.leaving import Leaving
from ppaas.costmap.map_layers import MapLayers
from ppaas.costmap.moving_obstacles import Disc
from ppaas.costmap.narrow_passages import fits_at, narrowed
from ppaas.costmap.obstacle_layer import OBSTACLE_RANGE, RAYTRACE_RANGE, LaserReading, ObstacleLayer
from ppaas.costmap.social_layer import PersonNearby, Proxemics
from ppaas.errors import InvalidInput, InvalidMap, InvalidParameter
from ppaas.footprints import Footprint
from ppaas.geometry import Pose2D, convex_outline
from ppaas.maps.discs import stamp_disc
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN, GridInfo
from ppaas.maps.kernels.distance import distance_serial

MAX_CELLS = 1 << 22
"""Limit of the number of cells of a window."""

OFF_MAP = 0.1
"""Distance from obstacles of the map beyond which an obstacle is another one [m]."""

PROXEMICS = Proxemics()
"""Default costs around people."""


class LocalCostmap:
    """Rolling window on the cells of the map. It is not thread-safe.

    Parameters
    ----------
    layers : MapLayers
        Layers of the robot's map; the window may extend beyond the map.
    width, height : float
        Size of the window [m].
    robot_radius : float
        Inscribed radius of the robot [m].
    inflation_radius : float
        Distance from obstacles up to which cells have a cost [m].
    cost_scaling_factor : float
        Rate at which costs decay with the distance [1/m].
    obstacle_range : float
        Longest range that marks an obstacle [m].
    raytrace_range : float
        Range up to which beams clear cells [m].
    inf_is_valid : bool
        Whether a beam that hit nothing clears cells.
    static : bool
        Whether obstacles, unknown cells and keep-out zones of the map count. Without them, unseen cells are free.
    social : Proxemics
        Costs around people.
    footprint : Footprint
        Outline of the robot, of which the convex hull is free; empty for the disc of ``robot_radius``.
    inner_radius : float, optional
        With a footprint: radius within which `update` returns the costs of an obstacle [m]. Farther away
        they are `NARROW`, since the outline may fit.

    Raises
    ------
    InvalidParameter
        A parameter is out of range; the text names it.
    """

    def __init__(
        self,
        layers: MapLayers,
        *,
        width: float = 6.0,
        height: float = 6.0,
        robot_radius: float = ROBOT_RADIUS,
        inflation_radius: float = INFLATION_RADIUS,
        cost_scaling_factor: float = COST_SCALING_FACTOR,
        obstacle_range: float = OBSTACLE_RANGE,
        raytrace_range: float = RAYTRACE_RANGE,
        inf_is_valid: bool = True,
        static: bool = True,
        social: Proxemics = PROXEMICS,
        footprint: Footprint = (),
        inner_radius: float | None = None,
    ) -> None:
        self._layers = layers
        self._way_out: Costmap | None = None
        self._static = static
        self._radius = robot_radius
        self._hull = convex_outline(footprint) if footprint else None
        self._inner_radius = inner_radius
        self._exact_to = max(robot_radius, inflation_radius, inner_radius or 0.0)
        check_inflation(robot_radius, inflation_radius, cost_scaling_factor)
        self._inflate = partial(
            inflate,
            inscribed_radius=robot_radius,
            inflation_radius=inflation_radius,
            cost_scaling_factor=cost_scaling_factor,
        )
        self._size = height, width
        self._sensing = partial(
            ObstacleLayer, obstacle_range=obstacle_range, raytrace_range=raytrace_range, inf_is_valid=inf_is_valid
        )
        self._social = social
        self._leaving = Leaving(layers, robot_radius, self._hull)
        self._begin()

    def _begin(self) -> None:
        resolution = self._layers.grid.info.resolution
        self._obstacles = self._sensing(*_cells_of(*self._size, resolution), resolution)
        self._costs = self._obstacles.cells.copy()
        self._newly_lethal = self._near_people = False

    @property
    def layers(self) -> MapLayers:
        """Layers of the map; while the robot leaves a keep-out zone, those by which it does."""
        return self._layers

    @property
    def map_layers(self) -> MapLayers:
        """Layers of the map, also while the robot leaves a zone."""
        return self._leaving.map_layers

    @property
    def way_out(self) -> Costmap | None:
        """Costs of the whole map by which the robot leaves a keep-out zone; None unless it is in one.

        Observed obstacles are among them.
        """
        if not self._leaving.active:
            return None
        if self._way_out is None:
            data = self._inflate(self._layers.to_lethal, unknown=self._layers.grid.data == UNKNOWN)
            assert self._layers.keepout is not None
            raise_costs(data, self._layers.keepout.data)
            self._way_out = replace(self._layers.costmap, data=data, indexes=None)
        return self._way_out

    @property
    def seen_points(self) -> NDArray[np.float64]:
        """(n, 2) float64 array: centres of the cells in which the laser sees obstacles, in the frame of the map [m]."""
        corner = np.array((self._obstacles.row, self._obstacles.column))
        return self._layers.grid.info.to_world(np.argwhere(self._obstacles.marked) + corner).reshape(-1, 2)

    def use_layers(self, layers: MapLayers) -> None:
        """Replace the map; costs follow with the next `update`.

        What the laser saw is kept if the cells of both maps coincide, and forgotten otherwise.
        """
        shift = self._layers.grid.info.shift_to(layers.grid.info)
        self._leaving.use_layers(layers)
        self._use(layers)
        if shift is None:
            # The cells of the maps do not coincide, so what was seen cannot be kept.
            self._begin()
        else:
            self._obstacles.row += shift[0]
            self._obstacles.column += shift[1]

    def _use(self, layers: MapLayers) -> None:
        self._layers, self._way_out = layers, None

    @property
    def obstacles(self) -> ObstacleLayer:
        """Obstacle layer of the window, in cells of the map."""
        return self._obstacles

    @property
    def reach(self) -> float:
        """Distance from the centre of the window to its corners [m]."""
        height, width = self._obstacles.cells.shape
        return 0.5 * math.hypot(height, width) * self._layers.grid.info.resolution

    def sees_at(self, x: float, y: float, radius: float) -> bool:
        """Return whether the laser has seen what is not on the map within a disc, in the frame of the map [m]."""
        info = self._layers.grid.info
        centre = info.origin.inverse() @ Pose2D(x, y)
        corner = np.array((self._obstacles.row, self._obstacles.column))
        cells = corner + np.argwhere(self._obstacles.marked)
        row, column = centre.y / info.resolution - 0.5, centre.x / info.resolution - 0.5
        near = cells[np.hypot(*(cells - (row, column)).T) <= radius / info.resolution]
        inside = ((near >= 0) & (near < info.shape)).all(axis=1)
        to_static = self._layers.to_lethal[tuple(near[inside].T)]
        return bool((to_static > OFF_MAP).any() or not inside.all())

    def update(
        self,
        pose: Pose2D,
        reading: LaserReading | None = None,
        obstacles: Iterable[Disc] = (),
        people: Iterable[PersonNearby] = (),
        between: Iterable[PersonNearby] = (),
    ) -> Costmap:
        """Centre the window on the robot, add a scan, and return the costs.

        Parameters
        ----------
        pose : Pose2D
            Pose of the robot, in the frame of the map.
        reading : LaserReading, optional
            The latest scan.
        obstacles : iterable of (x, y, radius)
            Other robots and moving obstacles, in the frame of the map [m]; valid for this update only.
        people : iterable of PersonNearby
            People to keep a distance from; valid for this update only.
        between : iterable of PersonNearby
            Points between people who talk, which are avoided more than people are; valid for this update only.

        Returns
        -------
        Costmap
            A new costmap, aligned with the map. Cells that were not seen are unknown where the map is unknown or ends.

        Raises
        ------
        InvalidInput
            The pose or an obstacle is not finite.
        """
        self.see(pose, reading)
        here = self._layers.grid.info.origin.inverse() @ pose
        if self._hull is None:
            self._obstacles.clear_footprint(here, self._radius)
        else:
            self._obstacles.clear_outline(here, self._hull)
        lethal = self._obstacles.marked.view(np.uint8)
        self._stamp(lethal, obstacles)
        distance = self._distances(lethal)
        self._costs = self._cost(distance)
        costmap = Costmap(self._costs, self._info())
        self._near_people = self._social.add(costmap, people)
        self._near_people |= self._social.between().add(costmap, between)
        return costmap if self._inner_radius is None else narrowed(costmap, distance, self._inner_radius)

    @property
    def has_outline(self) -> bool:
        """The robot has a footprint, whose outline `fits` checks."""
        return self._hull is not None

    def fits(self, pose: Pose2D) -> bool:
        """Return whether the robot's outline touches no obstacle of the last update at a pose in the map's frame."""
        return self._hull is None or fits_at(Costmap(self._costs, self._info()), pose, self._hull)

    def see(self, pose: Pose2D, reading: LaserReading | None) -> None:
        """Centre the window on the robot, and add a scan; costs are as of the next `update`, whose errors it raises.

        A robot with several lasers adds the scans of all but one by this.
        """
        if not pose.is_finite():
            raise InvalidInput(f"the robot's pose must be finite, not {tuple(pose)}")
        # Zones may open for a robot that is in one, so that it finds its way out.
        if self._leaving.look(pose):
            self._use(self._leaving.layers)
        frame = self._layers.grid.info.origin.inverse()
        self._follow(frame @ pose)
        if reading is not None:
            self._obstacles.see(frame @ reading.origin, reading)

    def overlay(self, costmap: Costmap) -> Costmap:
        """Return a costmap of the whole map combined with the last update, for replanning.

        Within the window each cost is the higher of the two; unknown cells of the map change only if they are blocked.
        The given costmap is not modified, and is returned itself if there is no new obstacle.

        Raises
        ------
        InvalidMap
            The costmap belongs to another map.
        """
        if costmap.info != self._layers.grid.info:
            raise InvalidMap("the costmap and the local costmap belong to different maps")
        inner, outer = self._overlap()
        local = self._costs[inner]
        if not ((self._newly_lethal or self._near_people) and local.size):
            return costmap
        current = costmap.copied(outer)
        part = current.data[outer]
        # What the laser has not seen yet must not hide what the map knows.
        known = np.where(local == NO_INFORMATION, 0, local)
        blocked = known >= INSCRIBED_INFLATED_OBSTACLE
        part[:] = np.where((part == NO_INFORMATION) & blocked, known, np.maximum(part, known))
        return current

    def clear(self, around: Pose2D | None = None, beyond: float = 0.0) -> None:
        """Forget all that the laser saw, or only beyond a distance [m] from a pose in the frame of the map.

        It takes effect with the next update.
        """
        if around is None:
            self._obstacles.clear()
        else:
            self._obstacles.clear_beyond(self._layers.grid.info.origin.inverse() @ around, beyond)
        self._newly_lethal = bool(self._newly_lethal and self._obstacles.marked.any())

    def free(self, discs: Iterable[Disc]) -> None:
        """Free the cells within discs, in the frame of the map, because a moving obstacle has left them."""
        frame = self._layers.grid.info.origin.inverse()
        for x, y, radius in discs:
            self._obstacles.clear_footprint(frame @ Pose2D(x, y), radius)

    def _follow(self, robot: Pose2D) -> None:
        """Centre the window on the robot, in the frame of the grid."""
        resolution = self._layers.grid.info.resolution
        height, width = self._obstacles.cells.shape
        row, column = math.floor(robot.y / resolution), math.floor(robot.x / resolution)
        self._obstacles.move_to(row - height // 2, column - width // 2)

    def _stamp(self, lethal: NDArray[np.uint8], obstacles: Iterable[Disc]) -> None:
        info = self._layers.grid.info
        frame = info.origin.inverse()
        for x, y, radius in obstacles:
            if not (math.isfinite(radius) and radius >= 0.0 and math.isfinite(x) and math.isfinite(y)):
                raise InvalidInput(f"an obstacle must have a finite x, y and radius, not {(x, y, radius)}")
            centre = frame @ Pose2D(x, y)
            column = centre.x / info.resolution - self._obstacles.column
            row = centre.y / info.resolution - self._obstacles.row
            stamp_disc(lethal, column, row, radius / info.resolution, 1)

    def _distances(self, lethal: NDArray[np.uint8]) -> NDArray[np.float32]:
        """Return the distance of each cell to the nearest lethal one and, if ``static``, obstacle of the map [m].

        Distances beyond those at which obstacles have costs may be too large.
        Obstacles of the map outside the window count as well, since the distances are for the whole map.
        """
        resolution = self._layers.grid.info.resolution
        if not self._static:
            self._newly_lethal = bool(lethal.any())
            return distance_serial(lethal, resolution)
        to_static = self._window(self._layers.to_lethal, np.float32(np.inf))
        occupied = to_static == 0.0
        if self._layers.keepout is not None:  # what the robot does not leave stays lethal while it leaves something
            occupied |= self._window(self._layers.keepout.data, np.int8(FREE)) == OCCUPIED
        new = lethal.view(np.bool_) & ~occupied
        self._newly_lethal = bool(new.any())
        # In a window within the map the distances of the map are right but near the few obstacles that are new.
        if self._layers.keepout is None and to_static[self._overlap()[0]].size == to_static.size:
            reach = reach_in_cells(self._exact_to, resolution)
            if are_few(new, reach):
                lower_near(new.view(np.uint8), resolution, reach, to_static)
                return to_static
        distances: NDArray[np.float32] = np.minimum(distance_serial(lethal | occupied, resolution), to_static)
        return distances

    def _cost(self, distance: NDArray[np.float32]) -> NDArray[np.uint8]:
        """Return the costs around obstacles by these distances [m] and, if ``static``, in keep-out zones."""
        if not self._static:
            return self._inflate(distance)
        unknown = (self._window(self._layers.grid.data, np.int8(UNKNOWN)) == UNKNOWN) & ~self._obstacles.seen
        costs = self._inflate(distance, unknown=unknown)
        if self._layers.keepout is not None:
            raise_costs(costs, self._window(self._layers.keepout.data, np.int8(FREE)))
        return costs

    def _window(self, array: NDArray[Any], fill: Any) -> NDArray[Any]:
        """Return the window of a layer of the map, with ``fill`` outside the map."""
        cells = np.full(self._obstacles.cells.shape, fill, array.dtype)
        inner, outer = self._overlap()
        cells[inner] = array[outer]
        return cells

    def _overlap(self) -> tuple[tuple[slice, slice], tuple[slice, slice]]:
        """Return the intersection of window and map, as slices of the window and of the map; both may be empty."""
        row, column = self._obstacles.row, self._obstacles.column
        rows = _common(row, self._obstacles.cells.shape[0], self._layers.grid.info.height)
        columns = _common(column, self._obstacles.cells.shape[1], self._layers.grid.info.width)
        return (rows[0], columns[0]), (rows[1], columns[1])

    def _info(self) -> GridInfo:
        info = self._layers.grid.info
        height, width = self._obstacles.cells.shape
        corner = Pose2D(self._obstacles.column * info.resolution, self._obstacles.row * info.resolution)
        origin = info.origin @ corner
        return GridInfo(info.resolution, width, height, Pose2D(origin.x, origin.y, info.origin.theta))


def _common(start: int, length: int, size: int) -> tuple[slice, slice]:
    low = min(max(start, 0), size)
    high = max(min(start + length, size), low)
    return slice(low - start, high - start) if high > low else slice(0, 0), slice(low, high)


def _cells_of(height: float, width: float, resolution: float) -> tuple[int, int]:
    if not (math.isfinite(height) and math.isfinite(width) and height > 0.0 and width > 0.0):
        raise InvalidParameter(f"width and height must be finite and above 0 m, not {width} and {height}")
    rows, columns = max(round(height / resolution), 1), max(round(width / resolution), 1)
    if rows * columns > MAX_CELLS:
        raise InvalidParameter(f"width and height give {columns}×{rows} cells; at most {MAX_CELLS} are allowed")
    return rows, columns
