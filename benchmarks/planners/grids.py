"""The grids that planners are measured on: made up, or from any map file."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import FREE_SPACE, INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE, NO_INFORMATION, Costmap
from ppaas.errors import GoalOccupied, GoalOutsideMap, InvalidMap, InvalidParameter
from ppaas.maps.formats.movingai import parse_map
from ppaas.maps.formats.pgm import parse_pgm
from ppaas.maps.grid import OCCUPIED_THRESHOLD, GridInfo, GridMap
from ppaas.planners.ends import Cell
from ppaas.planners.weights import FACTOR, NEUTRAL, passable
from robots.client.map_files import read_map_file
from robots.plans.offline import PlannedRobot, costmap_of_file, yaml_of

LARGEST = 32768
"""Cells along an edge of a grid that is made up."""

RESOLUTION = 0.05
SEED = 1

_NAVFN_UNKNOWN = 253


@dataclass(frozen=True, slots=True)
class Grid:
    """A costmap and what it is called; nobody can write to it, as in a container."""

    name: str
    costmap: Costmap


def empty(size: int) -> Grid:
    """Return a square without obstacles."""
    _check("an empty grid", size, 1)
    # Not zeros: what nobody has written to is one page of zeros, again and again, as no map of a robot is.
    return _grid(f"empty {size}²", np.full((size, size), FREE_SPACE, np.uint8))


def random(size: int, percent: float, seed: int = SEED) -> Grid:
    """Return a square in which so many percent of the cells are blocked, the same each time for a seed."""
    _check("a random grid", size, 1)
    if not 0.0 <= percent < 100.0:
        raise InvalidParameter(f"from 0 to less than 100 percent of a grid can be blocked, not {percent:g}")
    blocked = np.random.default_rng(seed).random((size, size), np.float32) < percent / 100.0
    return _grid(f"random {percent:g} % {size}²", np.where(blocked, LETHAL_OBSTACLE, FREE_SPACE).astype(np.uint8))


def maze(size: int, width: int = 1, seed: int = SEED) -> Grid:
    """Return a perfect maze: between any two cells of its corridors there is one way, the same each time for a seed.

    Parameters
    ----------
    size : int
        Edge of the square [cells].
    width : int
        Of a corridor [cells]; a wall has one.
    seed : int

    Notes
    -----
    A random spanning tree (Kruskal's, by random weights) of rooms that touch: its edges are the doors.
    """
    if width < 1:
        raise InvalidParameter(f"a corridor is 1 or more cells wide, not {width}")
    _check(f"a maze with corridors of {width}", size, width + 2)
    rooms = (size - 1) // (width + 1)
    doors = _doors(rooms, seed)
    repeats = np.tile((width, 1), rooms)[:-1]
    inner = doors.repeat(repeats, axis=0).repeat(repeats, axis=1)
    costs = np.full((size, size), LETHAL_OBSTACLE, np.uint8)
    costs[1 : 1 + len(inner), 1 : 1 + len(inner)][inner] = FREE_SPACE
    return _grid(f"maze {width} wide, {size}²", costs)


def from_file(path: Path) -> Grid:
    """Read any map file.

    A ``.map`` is one of MovingAI's, taken as it is. A YAML file, or its image, is a map of map_server, inflated as
    containers do it for the robot they plan for where none is named. An image without a YAML file beside it is a
    costmap, row 0 at its top: of costmap_2d, or, where no byte is below 50, of navfn, as ROS keeps one to test navfn
    with: 50 + 0.8·cost, 253 unknown, 254 and 255 blocked.

    Raises
    ------
    InvalidMap
        It cannot be read, or is none of these.
    """
    if path.suffix == ".map":
        grid = map_from_file(path)
        costs = np.where(grid.data >= OCCUPIED_THRESHOLD, LETHAL_OBSTACLE, FREE_SPACE).astype(np.uint8)
        return _grid(path.stem, costs, grid.info)
    if path.suffix.lower() == ".pgm" and not yaml_of(path).exists():
        pixels = parse_pgm(_bytes(path))
        return _grid(path.stem, _navfn_costs(pixels) if pixels.min() >= NEUTRAL else pixels)
    costmap = costmap_of_file(path, PlannedRobot().radius_of())
    return _grid(path.stem, costmap.data, costmap.info)


def tiled(grid: Grid, copies: int) -> Grid:
    """Return a grid of so many by so many copies of one, side by side.

    Raises
    ------
    InvalidParameter
        It would be none, or larger than any grid may be.
    """
    _check(f"{copies} by {copies} times {grid.name}", copies * max(grid.costmap.data.shape), 1)
    if copies == 1:
        return grid
    return _grid(f"{copies} by {copies} times {grid.name}", np.tile(grid.costmap.data, (copies, copies)))


def map_from_file(path: Path) -> GridMap:
    """Read a map of MovingAI's, or one of map_server by its YAML file or image.

    Raises
    ------
    InvalidMap
        It cannot be read, or is neither.
    """
    return parse_map(_bytes(path)) if path.suffix == ".map" else read_map_file(yaml_of(path))


def goal_in(costmap: Costmap, goal: Cell | None = None) -> Cell:
    """Return a goal: the cell asked for, else the one nearest to the middle in the largest region that hangs together.

    Raises
    ------
    GoalOutsideMap, GoalOccupied
        The goal asked for cannot be one, or no cell at all is free.
    """
    free = passable(True)[costmap.data]
    if goal is not None:
        if not (0 <= goal[0] < free.shape[0] and 0 <= goal[1] < free.shape[1]):
            raise GoalOutsideMap(f"row, column {goal} is outside the {free.shape[0]}×{free.shape[1]} map")
        if not free[goal]:
            raise GoalOccupied(f"row, column {goal} is not free; choose a free cell, or let one be chosen")
        return goal
    from scipy import ndimage  # noqa: PLC0415 - of the extra bench

    # A diagonal needs both cells beside it, so regions hang together by their cardinal neighbours.
    regions, count = ndimage.label(free)
    if not count:
        raise GoalOccupied("no cell of the map is free: there is nothing to plan")
    largest = int(np.argmax(np.bincount(regions.ravel())[1:])) + 1
    cells = np.argwhere(regions == largest)
    offsets = cells - np.array(free.shape) // 2
    row, column = cells[np.argmin((offsets * offsets).sum(axis=1))].tolist()
    return row, column


def _grid(name: str, costs: NDArray[np.uint8], info: GridInfo | None = None) -> Grid:
    costs = np.ascontiguousarray(costs)
    costs.setflags(write=False)
    return Grid(name, Costmap(costs, info or GridInfo(RESOLUTION, costs.shape[1], costs.shape[0])))


def _check(what: str, size: int, least: int) -> None:
    if not least <= size <= LARGEST:
        raise InvalidParameter(f"{what} has an edge of {least} to {LARGEST} cells, not {size}")


def _doors(rooms: int, seed: int) -> NDArray[np.bool_]:
    """Return the (2·rooms − 1)² squares of a maze, rooms at even rows and columns: which of them are open."""
    from scipy.sparse import coo_array  # noqa: PLC0415 - of the extra bench
    from scipy.sparse.csgraph import minimum_spanning_tree  # noqa: PLC0415

    number = np.arange(rooms * rooms).reshape(rooms, rooms)
    first = np.concatenate((number[:, :-1].ravel(), number[:-1].ravel()))
    second = np.concatenate((number[:, 1:].ravel(), number[1:].ravel()))
    weights = 1.0 + np.random.default_rng(seed).random(len(first))
    tree = minimum_spanning_tree(
        coo_array((weights, (first, second)), shape=(number.size, number.size)).tocsr()
    ).tocoo()
    is_open = np.zeros((2 * rooms - 1, 2 * rooms - 1), np.bool_)
    is_open[::2, ::2] = True
    # A door is halfway between its two rooms.
    is_open[tree.row // rooms + tree.col // rooms, tree.row % rooms + tree.col % rooms] = True
    return is_open


def _navfn_costs(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    costs: NDArray[np.uint8] = (
        np.rint((pixels - NEUTRAL) / FACTOR).clip(0, INSCRIBED_INFLATED_OBSTACLE - 1).astype(np.uint8)
    )
    costs[pixels == _NAVFN_UNKNOWN] = NO_INFORMATION
    costs[pixels > _NAVFN_UNKNOWN] = LETHAL_OBSTACLE
    return costs


def _bytes(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise InvalidMap(f"cannot read the map: {error}") from error


KINDS: dict[str, Callable[[int, int], Grid]] = {
    "empty": lambda size, _: empty(size),
    "random 10 %": lambda size, seed: random(size, 10.0, seed),
    "random 20 %": lambda size, seed: random(size, 20.0, seed),
    "random 30 %": lambda size, seed: random(size, 30.0, seed),
    "maze": lambda size, seed: maze(size, seed=seed),
}
"""Grids that can be made in any size, alike by a seed."""
