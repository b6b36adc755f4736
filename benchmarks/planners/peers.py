"""Planners of packages from PyPI: calls, and the problems that they solve, which often differ from ours.

The conversion of a map to the input of a library is not part of its time.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import version
from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.planners.timing import timed
from ppaas.costmap.costmap import Costmap
from ppaas.distribution import NAME, install_hint
from ppaas.errors import NotFound
from ppaas.planners.ends import Cell
from ppaas.planners.grid import navfn
from ppaas.planners.weights import SQRT2, exact_weights, passable

_MOVES = ((0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, 1), (-1, -1))


def edges_of(weights: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """Return all moves away from the goal: flat indices of their source and target cells, and their costs.

    Parameters
    ----------
    weights : (height, width) array
        Weights of the cells, infinite if blocked. A move costs the weight of its target, which is farther from the
        goal.
    """
    free = np.isfinite(weights)
    padded = np.pad(free, 1)
    number = np.arange(weights.size).reshape(weights.shape)
    sources, targets, costs = [], [], []
    for down, right in _MOVES:
        is_open = free & _moved(padded, down, right)
        if down and right:
            is_open &= _moved(padded, down, 0) & _moved(padded, 0, right)
        source = number[is_open]
        target = source + down * weights.shape[1] + right
        sources.append(source)
        targets.append(target)
        costs.append(weights.ravel()[target] * (SQRT2 if down and right else 1.0))
    return np.concatenate(sources), np.concatenate(targets), np.concatenate(costs)


def graph_of(weights: NDArray[np.float64]) -> Any:
    """Return the graph as a sparse matrix for scipy's csgraph."""
    from scipy.sparse import coo_array  # noqa: PLC0415 - of the extra bench

    sources, targets, costs = edges_of(weights)
    return coo_array((costs, (sources, targets)), shape=(weights.size, weights.size)).tocsr()


def digraph_of(networkx: Any, weights: NDArray[np.float64]) -> Any:
    """Return the graph for networkx."""
    graph = networkx.DiGraph()
    graph.add_nodes_from(np.flatnonzero(np.isfinite(weights)).tolist())
    graph.add_weighted_edges_from(zip(*(ends.tolist() for ends in edges_of(weights)), strict=True))
    return graph


def _moved(padded: NDArray[np.bool_], down: int, right: int) -> NDArray[np.bool_]:
    """Return for each cell whether the cell at that offset is free."""
    height, width = padded.shape
    return padded[1 + down : height - 1 + down, 1 + right : width - 1 + right]


Field = NDArray[np.float64]
Cells = NDArray[np.integer]

SMALL, MIDDLE = 256 * 256, 2048 * 2048
"""Largest grids [cells] for libraries of Python objects, and for libraries that need a matrix of all moves."""

UNREACHED = 2**31 - 1
"""Value of unreached cells in tcod."""


@dataclass(frozen=True, slots=True)
class PeerProblem:
    """A planning problem on a grid.

    Parameters
    ----------
    costmap : Costmap
    goal, start : (row, column)
        Connected free cells.
    """

    costmap: Costmap
    goal: Cell
    start: Cell

    def free(self) -> NDArray[np.bool_]:
        """Return the (height, width) mask of free cells."""
        return passable(True)[self.costmap.data]

    def weights(self, blocked: float = np.inf) -> Field:
        """Return the (height, width) weights of the cells, with ``blocked`` for blocked cells."""
        return np.where(self.free(), exact_weights()[self.costmap.data], blocked)


@dataclass(frozen=True, slots=True)
class Peer:
    """A function of a library.

    Parameters
    ----------
    name : str
        Name of the function.
    package, module : str
        Its package on PyPI, and its Python module.
    solves : str
        Problem that it solves, and the difference from ours.
    prepare : callable
        Returns the timed call, from the imported module and a problem.
    told : callable
        Converts the result of the call to a field in our units, infinite for unreached cells, or to the cells of a
        path.
    most : int, optional
        Largest grid [cells] on which it is measured.
    """

    name: str
    package: str
    module: str
    solves: str
    prepare: Callable[[Any, PeerProblem], Callable[[], Any]]
    told: Callable[[Any, PeerProblem], Any]
    most: int | None = None

    @property
    def installed(self) -> str | None:
        """Installed version, or None."""
        return version(self.package) if find_spec(self.module.partition(".")[0]) else None

    def why_not(self, cells: int) -> str | None:
        """Return why it cannot be measured on a grid of that many cells; None if it can."""
        if not self.installed:
            return f"not installed: {install_hint('bench')}"
        return "the grid is too large" if self.most is not None and cells > self.most else None

    def call(self, problem: PeerProblem) -> tuple[float, Callable[[], Any]]:
        """Return the time of the preparation [s], and the call to be timed."""
        module = import_module(self.module)
        return timed(lambda: self.prepare(module, problem))


# -- fields ------------------------------------------------------------------------------------------------------------


def _tcod_field(tcod: Any, problem: PeerProblem) -> Callable[[], Any]:
    costs = _whole_costs(problem)

    def call() -> Any:
        distance = tcod.maxarray(costs.shape, dtype=np.int32)
        distance[problem.goal] = 0
        return tcod.dijkstra2d(distance, costs, cardinal=2, diagonal=3, out=distance)

    return call


def _tcod_told(distance: Any, problem: PeerProblem) -> Field:
    # If all cells have the same weight, tcod gets weights of 1, and a cardinal move costs 2 units.
    unit = 1.0 / 2.0 if _graded(problem) else float(problem.weights()[problem.goal]) / 2.0
    return np.where(distance == UNREACHED, np.inf, distance * unit)


def _whole_costs(problem: PeerProblem) -> NDArray[np.int32]:
    free = problem.free()
    return (np.rint(problem.weights(blocked=0.0)) if _graded(problem) else free).astype(np.int32)


def _graded(problem: PeerProblem) -> bool:
    weights = problem.weights()[problem.free()]
    return bool(weights.min() != weights.max())


def _dijkstra3d_field(dijkstra3d: Any, problem: PeerProblem) -> Callable[[], Any]:
    weights = problem.weights().astype(np.float32)
    return lambda: dijkstra3d.distance_field(weights, source=problem.goal, connectivity=8)


def _scipy_field(csgraph: Any, problem: PeerProblem) -> Callable[[], Any]:
    graph = graph_of(problem.weights())
    return lambda: csgraph.dijkstra(graph, indices=np.ravel_multi_index(problem.goal, problem.costmap.data.shape))


def _mcp_field(skimage: Any, problem: PeerProblem) -> Callable[[], Any]:
    weights = problem.weights(blocked=-1.0)
    return lambda: skimage.MCP_Geometric(weights).find_costs([problem.goal])[0]


def _eikonal_field(skfmm: Any, problem: PeerProblem) -> Callable[[], Any]:
    free, weights = problem.free(), problem.weights(blocked=1.0)
    front = np.ma.MaskedArray(np.ones(free.shape), ~free)
    front[problem.goal] = -1.0  # the zero contour, where the front begins, is halfway to its neighbours
    return lambda: skfmm.travel_time(front, 1.0 / weights)


def _networkx_field(networkx: Any, problem: PeerProblem) -> Callable[[], Any]:
    graph = digraph_of(networkx, problem.weights())
    goal = int(np.ravel_multi_index(problem.goal, problem.costmap.data.shape))
    return lambda: networkx.single_source_dijkstra_path_length(graph, goal)


def _from_dict(lengths: Any, problem: PeerProblem) -> Field:
    field = np.full(problem.costmap.data.size, np.inf)
    field[list(lengths)] = list(lengths.values())
    return field.reshape(problem.costmap.data.shape)


def _as_field(values: Any, problem: PeerProblem) -> Field:
    return np.ma.filled(values, np.inf).astype(np.float64).reshape(problem.costmap.data.shape)


FIELDS = (
    Peer("dijkstra2d", "tcod", "tcod.path", "integer costs, 2 per cardinal and 3 per diagonal move; cuts corners",
         _tcod_field, _tcod_told),
    Peer("distance_field", "dijkstra3d", "dijkstra3d", "a diagonal move costs as much as a cardinal one; cuts corners",
         _dijkstra3d_field, _as_field),
    Peer("csgraph.dijkstra", "scipy", "scipy.sparse.csgraph",
         "the same problem, exactly; the graph is built beforehand, which takes longer than the search",
         _scipy_field, _as_field, MIDDLE),
    Peer("MCP_Geometric", "scikit-image", "skimage.graph", "a move costs the mean of its two cells; cuts corners",
         _mcp_field, _as_field),
    Peer("travel_time", "scikit-fmm", "skfmm", "the eikonal equation: straight lines in any direction",
         _eikonal_field, _as_field),
    Peer("single_source_dijkstra", "networkx", "networkx", "the same problem, exactly; the graph is built beforehand",
         _networkx_field, _from_dict, SMALL),
)  # fmt: skip


def _navfn_field(navfn: Any, problem: PeerProblem) -> Callable[[], Any]:
    def call() -> Any:
        function = navfn.NavigationFunction(problem.costmap, problem.goal)
        function.grow()
        return function

    return call


NAVFN = Peer("navfn", NAME, navfn.__name__,
             "ROS's planner, compiled by numba like ours; interpolates potentials between cells, on one thread",
             _navfn_field, lambda function, problem: _as_field(function.potentials(), problem))  # fmt: skip
"""ROS's planner as implemented in ``ppaas``, the baseline of the paper; its setup is timed, as ours is."""

BESIDE = {"navfn": NAVFN} | {peer.package: peer for peer in FIELDS}
"""Other implementations of a field, by name."""


def beside(names: Sequence[str]) -> dict[str, Peer]:
    """Return the implementations of some names.

    Raises
    ------
    NotFound
        A name is unknown.
    """
    for name in names:
        if name not in BESIDE:
            raise NotFound("peer", name, tuple(BESIDE))
    return {name: BESIDE[name] for name in names}


# -- one path ----------------------------------------------------------------------------------------------------------


def _pyastar_path(pyastar2d: Any, problem: PeerProblem) -> Callable[[], Any]:
    weights = (problem.weights() / exact_weights()[0]).astype(np.float32)
    return lambda: pyastar2d.astar_path(weights, problem.start, problem.goal, allow_diagonal=True)


def _nano_path(nano_astar: Any, problem: PeerProblem) -> Callable[[], Any]:
    blocked = (~problem.free()).astype(np.uint8)
    return lambda: nano_astar.astar(blocked, problem.start, problem.goal, heuristic="octile", diagonal=True)[0]


def _tcod_path(tcod: Any, problem: PeerProblem) -> Callable[[], Any]:
    costs = _whole_costs(problem)

    def call() -> Any:
        finder = tcod.Pathfinder(tcod.SimpleGraph(cost=costs, cardinal=2, diagonal=3))
        finder.add_root(problem.start)
        return finder.path_to(problem.goal)

    return call


def _skimage_path(skimage: Any, problem: PeerProblem) -> Callable[[], Any]:
    weights = problem.weights(blocked=-1.0)
    return lambda: skimage.route_through_array(weights, problem.start, problem.goal)[0]


def _dijkstra3d_path(dijkstra3d: Any, problem: PeerProblem) -> Callable[[], Any]:
    weights = problem.weights().astype(np.float32)
    return lambda: dijkstra3d.dijkstra(weights, problem.start, problem.goal, connectivity=8, anisotropy=(1.0, 1.0, 1.0))


def _networkx_path(networkx: Any, problem: PeerProblem) -> Callable[[], Any]:
    graph = digraph_of(networkx, problem.weights())
    start, goal = (
        int(np.ravel_multi_index(cell, problem.costmap.data.shape)) for cell in (problem.start, problem.goal)
    )
    return lambda: np.stack(
        np.unravel_index(networkx.bidirectional_dijkstra(graph, goal, start)[1][::-1], problem.costmap.data.shape),
        axis=1,
    )


def _as_cells(cells: Any, _: PeerProblem) -> Cells:
    return np.empty((0, 2), np.int64) if cells is None else np.asarray(cells, np.int64)


PATHS = (
    Peer("astar_path", "pyastar2d", "pyastar2d", "a diagonal move costs as much as a cardinal one; cuts corners",
         _pyastar_path, _as_cells),
    Peer("astar", "nano-astar", "nano_astar", "free and blocked cells only, without costs; exact for those",
         _nano_path, _as_cells),
    Peer("Pathfinder", "tcod", "tcod.path",
         "A* with integer costs, 2 per cardinal and 3 per diagonal move; cuts corners", _tcod_path, _as_cells),
    Peer("route_through_array", "scikit-image", "skimage.graph",
         "a move costs the mean of its two cells; cuts corners", _skimage_path, _as_cells),
    Peer("dijkstra", "dijkstra3d", "dijkstra3d", "a diagonal move costs √2; cuts corners",
         _dijkstra3d_path, _as_cells),
    Peer("bidirectional_dijkstra", "networkx", "networkx", "the same problem, exactly; the graph is built beforehand",
         _networkx_path, _as_cells, SMALL),
)  # fmt: skip
