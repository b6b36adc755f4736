"""Grids of the planner benches: generated, or read from a map file."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import FREE_SPACE, INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE, NO_INFORMATION, Costmap
from ppaas.errors import GoalOccupied, GoalOutsideMap, InvalidMap, InvalidParameter, NotFound
from ppaas.maps.formats.netpbm import open_pgm
from ppaas.maps.grid import OCCUPIED_THRESHOLD, GridInfo
from ppaas.planners.ends import Cell
from ppaas.planners.weights import FACTOR, NEUTRAL, passable
from robots.client.map_files import is_movingai, read_map_file, yaml_of
from robots.plans.offline import PlannedRobot, costmap_for

LARGEST = 32768
"""Largest edge of a grid [cells]."""

RESOLUTION = 0.05
SEED = 1

_NAVFN_UNKNOWN = 253


@dataclass(frozen=True, slots=True)
class Grid:
    """A named costmap, read-only as in a container."""

    name: str
    costmap: Costmap


def empty(size: int) -> Grid:
    """Return a square without obstacles."""
    _check("an empty grid", size, 1)
    # Not np.zeros, whose untouched memory would be one shared page of zeros.
    return _grid(f"empty {size}²", np.full((size, size), FREE_SPACE, np.uint8))


def random(size: int, percent: float, seed: int = SEED) -> Grid:
    """Return a square in which random cells are blocked, ``percent`` of them on average; equal for equal seeds."""
    _check("a random grid", size, 1)
    if not 0.0 <= percent < 100.0:
        raise InvalidParameter(f"the percentage of blocked cells must be at least 0 and below 100, not {percent:g}")
    blocked = np.random.default_rng(seed).random((size, size), np.float32) < percent / 100.0
    return _grid(f"random {percent:g} % {size}²", np.where(blocked, LETHAL_OBSTACLE, FREE_SPACE).astype(np.uint8))


def maze(size: int, width: int = 1, seed: int = SEED) -> Grid:
    """Return a perfect maze: any two cells of its corridors are connected by one path; equal for equal seeds.

    Parameters
    ----------
    size : int
        Edge of the square [cells].
    width : int
        Width of a corridor [cells]; walls are one cell wide.
    seed : int

    Notes
    -----
    The doors are the edges of a random spanning tree (Kruskal's algorithm with random weights) of adjacent rooms.
    """
    if width < 1:
        raise InvalidParameter(f"the width of corridors must be 1 cell or more, not {width}")
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

    A ``.map`` is a MovingAI map and is not inflated. A YAML file or its image is a map of map_server; it is inflated as
    in containers for the default robot. A PGM without a YAML file beside it is a costmap, with row 0 at the top: of
    costmap_2d, or, if no byte is below 50, of navfn, such as the one with which ROS tests navfn: 50 + 0.8·cost, 253
    unknown, 254 and 255 blocked.

    Raises
    ------
    InvalidMap
        The file cannot be read, or has another format.
    """
    if is_movingai(path):
        grid = read_map_file(path)
        costs = np.where(grid.data >= OCCUPIED_THRESHOLD, LETHAL_OBSTACLE, FREE_SPACE).astype(np.uint8)
        return _grid(path.stem, costs, grid.info)
    if path.suffix.lower() == ".pgm" and not yaml_of(path).exists():
        image = open_pgm(_bytes(path))
        pixels = image.rows(0, image.shape[0])
        return _grid(path.stem, _navfn_costs(pixels) if pixels.min() >= NEUTRAL else pixels)
    costmap = costmap_for(path, PlannedRobot())
    return _grid(path.stem, costmap.data, costmap.info)


def tiled(grid: Grid, copies: int) -> Grid:
    """Return a grid of ``copies`` by ``copies`` copies of a grid, side by side.

    Raises
    ------
    InvalidParameter
        The number of copies is below 1, or the grid would be too large.
    """
    _check(f"{copies} by {copies} times {grid.name}", copies * max(grid.costmap.data.shape), 1)
    if copies == 1:
        return grid
    return _grid(f"{copies} by {copies} times {grid.name}", np.tile(grid.costmap.data, (copies, copies)))


def goal_in(costmap: Costmap, goal: Cell | None = None) -> Cell:
    """Return the given goal, or the cell nearest to the middle in the largest connected region.

    Raises
    ------
    GoalOutsideMap, GoalOccupied
        The given goal is not a free cell of the map, or no cell is free.
    """
    free = passable(True)[costmap.data]
    if goal is not None:
        if not (0 <= goal[0] < free.shape[0] and 0 <= goal[1] < free.shape[1]):
            raise GoalOutsideMap(f"row, column {goal} is outside the {free.shape[0]}×{free.shape[1]} map")
        if not free[goal]:
            raise GoalOccupied(f"row, column {goal} is not free; give a free cell, or no goal")
        return goal
    from scipy import ndimage  # noqa: PLC0415 - of the extra bench

    # A diagonal move needs both cells beside it, so regions are connected by cardinal neighbours.
    regions, count = ndimage.label(free)
    if not count:
        raise GoalOccupied("no cell of the map is free, so no path can be planned")
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
        raise InvalidParameter(f"the edge of {what} must be {least} to {LARGEST} cells, not {size}")


def _doors(rooms: int, seed: int) -> NDArray[np.bool_]:
    """Return the (2·rooms − 1)² mask of open squares of a maze; rooms are at even rows and columns, doors between."""
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
    # A door is midway between its two rooms.
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
"""Generators of grids by name, called with an edge [cells] and a seed."""


def check_kinds(kinds: Iterable[str]) -> None:
    """Raise ``NotFound`` for a kind of grid that is none of ``KINDS``."""
    for kind in kinds:
        if kind not in KINDS:
            raise NotFound("kind of grid", kind, tuple(KINDS))
