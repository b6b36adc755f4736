"""Lane roadmap: cells along lanes that were drawn by hand; and the choice of the roadmap of a map."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ppaas.errors import InvalidInput
from ppaas.fleet.lane_drawing import DrawnLane, LaneConflict, lines_in, network_of
from ppaas.fleet.lane_placing import Placed, placed_on
from ppaas.fleet.lattice_roadmap import lattice_roadmap
from ppaas.fleet.metric_roadmap import Cells, MetricRoadmap
from ppaas.fleet.roadmap import BLOCKED, Roadmap
from ppaas.fleet.robot_sizes import RobotSizes
from ppaas.maps.grid import GridInfo
from ppaas.planners.watch import proceed
from ppaas.polygons import Points, distances_between, distances_to_edges
from ppaas.zones.zone import Zone

# -- distances between moves: robots on two of them must not touch -----------------------------------------------------

ROUNDING = 1e-6
"""Distance by which moves may be too near, since numbers are rounded [m]."""


def check_apart(placed: Placed, spacing: float) -> None:
    """Check that all that does not share a cell is at least a spacing apart: moves, and cells beside moves.

    Raises
    ------
    LaneConflict
        Two lanes are too near to each other; the text names them, and where.
    """
    moves = np.array(sorted({(min(move), max(move)) for move in placed.names}), np.int64)
    begins, ends = placed.centres[moves[:, 0]], placed.centres[moves[:, 1]]
    longest = float(np.hypot(*(ends - begins).T).max())
    pairs = cKDTree((begins + ends) / 2.0).query_pairs(longest + spacing, output_type="ndarray")
    one, other = pairs[:, 0], pairs[:, 1]
    apart = distances_between(begins[one], ends[one], begins[other], ends[other])
    shared = (moves[one][:, :, np.newaxis] == moves[other][:, np.newaxis]).any(axis=(1, 2))
    apart[shared] = _apart_beside(moves[one[shared]], moves[other[shared]], placed.centres)
    for worst in np.argsort(apart)[:1]:
        if apart[worst] < spacing - ROUNDING:
            names = sorted({_name(placed, moves[one[worst]]), _name(placed, moves[other[worst]])})
            x, y = (begins[one[worst]] + ends[one[worst]] + begins[other[worst]] + ends[other[worst]]) / 4.0
            what = f"lanes {names[0]!r} and {names[1]!r}" if len(names) > 1 else f"parts of lane {names[0]!r}"
            raise LaneConflict(
                f"{what} are {apart[worst]:.2f} m apart near {x:.2f}, {y:.2f}, and "
                f"robots of this size need {spacing:.2f} m: draw them farther apart, or join them",
                names,
            )


def _apart_beside(moves: NDArray[np.int64], others: NDArray[np.int64], centres: Points) -> NDArray[np.float64]:
    """Return how near the far end of each of two moves that share a cell is to the other move, row by row [m]."""
    swapped = (moves[:, 0, np.newaxis] == others).any(axis=1)
    own = np.where(swapped, moves[:, 1], moves[:, 0])
    shared = np.where(swapped, moves[:, 0], moves[:, 1])
    far = np.where(others[:, 0] == shared, others[:, 1], others[:, 0])
    a, b, c = centres[own], centres[shared], centres[far]
    return np.asarray(np.minimum(distances_to_edges(a, b, c), distances_to_edges(b, c, a)))


def _name(placed: Placed, move: NDArray[np.int64]) -> str:
    one, other = move.tolist()
    return placed.names.get((one, other)) or placed.names[other, one]


# -- the roadmap -------------------------------------------------------------------------------------------------------

SAMPLES = 2
"""Number of places on a move that are checked for each edge of a map cell."""


@dataclass(frozen=True, slots=True)
class LaneRoadmap(MetricRoadmap):
    """Cells along lanes.

    The area of a cell is what is within half a spacing beside its halves of the moves to its neighbours, and around its
    centre.

    Parameters
    ----------
    places : (v, 2) float64 array
        Centres of the cells in the map frame [m].
    """

    PLACES: ClassVar[str] = "lane with room for the robot"
    IS_GRID: ClassVar[bool] = False

    places: Points
    _halves: "_Halves" = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Derive the halves of the moves."""
        object.__setattr__(self, "_halves", _Halves.of(self.roadmap, self.places))

    @property
    def longest_move(self) -> float:
        """Length of the longest move [m]."""
        return max(2.0 * self._halves.longest, self.spacing)

    def centres_of(self, cells: Cells | slice) -> NDArray[np.float64]:
        """Return the centres of some cells, (k, 2) float64 array of x, y [m] in the map frame."""
        return np.asarray(self.places[cells])

    def centre(self, cell: int) -> tuple[float, float]:
        """Return the centre of a cell: x, y [m] in the map frame."""
        x, y = self.places[cell].tolist()
        return x, y

    def _around(self, x: float, y: float, reach: float) -> Cells:
        far = np.abs(self.places - (x, y)).max(axis=1)
        return np.nonzero(far <= reach + self.longest_move)[0].astype(np.int32)

    def _beside(self, cells: Cells, x: float, y: float) -> NDArray[np.float64]:
        middles = np.hypot(*(self.places[cells] - (x, y)).T) - self.spacing / 2.0
        return np.asarray(np.minimum(np.maximum(middles, 0.0), self._halves.beside(cells, x, y, self.spacing / 2.0)))

    def _apart(self, cells: Cells, x: float, y: float) -> NDArray[np.float64]:
        return np.asarray(np.minimum(np.hypot(*(self.places[cells] - (x, y)).T), self._halves.beside(cells, x, y, 0.0)))


@dataclass(frozen=True, slots=True)
class _Halves:
    """Halves of moves from and to each cell: straight lines from its centre; those that are missing are points.

    Parameters
    ----------
    begins, along : (v, 8, 2) float64 array
        Where each begins [m], and its direction.
    lengths : (v, 8) float64 array
        Its length [m].
    longest : float
        Greatest length [m].
    """

    begins: NDArray[np.float64]
    along: NDArray[np.float64]
    lengths: NDArray[np.float64]
    longest: float

    @classmethod
    def of(cls, roadmap: Roadmap, places: Points) -> "_Halves":
        begins = np.repeat(places[:, np.newaxis], 8, axis=1)
        near = np.concatenate([roadmap.neighbours, roadmap.incoming], axis=1)
        moves = np.where((near != BLOCKED)[:, :, np.newaxis], places[near] - begins, 0.0)
        lengths = np.hypot(moves[..., 0], moves[..., 1])
        along = moves / np.where(lengths > 0.0, lengths, 1.0)[:, :, np.newaxis]
        return cls(begins, along, lengths / 2.0, float(lengths.max(initial=0.0)) / 2.0)

    def beside(self, cells: Cells, x: float, y: float, width: float) -> NDArray[np.float64]:
        """Return how far a place is from the strips of a width [m] on both sides of the halves of some cells [m]."""
        offset = np.array((x, y)) - self.begins[cells]
        along = (offset * self.along[cells]).sum(axis=2)
        aside = np.abs(offset[..., 0] * self.along[cells, :, 1] - offset[..., 1] * self.along[cells, :, 0])
        past = np.maximum(np.maximum(-along, along - self.lengths[cells]), 0.0)
        apart = np.hypot(past, np.maximum(aside - width, 0.0))
        return np.asarray(np.where(self.lengths[cells] > 0.0, apart, np.inf).min(axis=1))


def lane_roadmap(
    lines: Sequence[DrawnLane], to_lethal: NDArray[np.float32], info: GridInfo, sizes: RobotSizes
) -> LaneRoadmap:
    """Return the roadmap of robots that drive along lanes only.

    Parts of lanes where not even the smallest robots have room are left out; larger robots do not enter cells where
    they have none. A move on which a robot has no room although it has in both cells is left out for all.

    Parameters
    ----------
    lines : sequence of DrawnLane
        At least one.
    to_lethal : (h, w) float32 array
        Distance from each map cell to the nearest lethal cell [m], 0 in unknown cells (`clearance_of`).
    info : GridInfo
        Geometry of the map.
    sizes : RobotSizes

    Raises
    ------
    InvalidInput
        Lanes are too near to each other, or robots have no room on any; the text names lanes and places.
    """
    placed = placed_on(network_of(lines), sizes.spacing)
    check_apart(placed, sizes.spacing)
    moves = np.array(list(placed.names), np.int64)
    rooms = [_Room(mask, info) for mask in sizes.room(to_lethal)]
    stands: NDArray[np.bool_] = np.stack([room.at(placed.centres) for room in rooms])
    passes = np.stack([room.along(placed.centres[moves[:, 0]], placed.centres[moves[:, 1]]) for room in rooms])
    blocked = stands[:, moves].all(axis=2) & ~passes
    moves = moves[passes[0] & ~blocked.any(axis=0)]
    if not len(moves):
        names = sorted(set(placed.names.values()))[:3]
        raise InvalidInput(
            f"robots of radius {sizes.radius:g} m with a margin of {sizes.margin:g} m have no room on lanes such as "
            f"{', '.join(map(repr, names))}"
        )
    kept = np.unique(moves)
    roadmap = Roadmap.of_pairs(len(kept), np.searchsorted(kept, moves).astype(np.int32))
    if sizes.radii:
        roadmap = replace(roadmap, barred=~stands[:, kept])
    return LaneRoadmap(roadmap, sizes.spacing, placed.centres[kept], radii=sizes.radii)


class _Room:
    """The part of a map where the centre of a robot may be.

    Parameters
    ----------
    mask : (h, w) bool array
        True in map cells where it may be; nowhere outside.
    info : GridInfo
    """

    def __init__(self, mask: NDArray[np.bool_], info: GridInfo) -> None:
        self._mask, self._info = mask, info

    def at(self, places: Points) -> NDArray[np.bool_]:
        """Return whether a robot may be at each place, (n,) bool."""
        cells = self._info.to_cells(places)
        inside: NDArray[np.bool_] = np.all((cells >= 0) & (cells < self._mask.shape), axis=1)
        return np.asarray(inside & self._mask[tuple(np.where(inside[:, np.newaxis], cells, 0).T)])

    def along(self, begins: Points, ends: Points) -> NDArray[np.bool_]:
        """Return whether a robot may be everywhere on each straight line, (n,) bool."""
        longest = float(np.hypot(*(ends - begins).T).max())
        parts = np.linspace(0.0, 1.0, int(SAMPLES * longest / self._info.resolution) + 2)
        free = np.ones(len(begins), np.bool_)
        for part in parts:
            free &= self.at(begins + part * (ends - begins))
        return free


# -- choice between lanes and the whole map ----------------------------------------------------------------------------


def roadmap_on(
    to_lethal: NDArray[np.float32],
    info: GridInfo,
    zones: Iterable[Zone],
    sizes: RobotSizes,
    check: Callable[[], None] = proceed,
) -> MetricRoadmap:
    """Return the roadmap along the lanes among the zones of a map, or over all of the map if there are none.

    Parameters
    ----------
    to_lethal : (h, w) float32 array
        Distance from each map cell to the nearest lethal cell [m], 0 in unknown cells (`clearance_of`).
    info : GridInfo
        Geometry of the map.
    zones : iterable of Zone
        Rules of others are not applied (`rules_on`).
    sizes : RobotSizes
    check : callable
        Called every now and then; ends the work by raising.

    Raises
    ------
    InvalidInput
        No robot of that size fits on the map or on a lane, or lanes are too near to each other.
    """
    lines = lines_in(zones)
    if lines:
        return lane_roadmap(lines, to_lethal, info, sizes)
    return lattice_roadmap(to_lethal, info, sizes, check)
