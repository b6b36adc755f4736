"""Builds an index: ground, graph, contraction, labels, and all of it laid into one array."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidPlanner
from ppaas.planners.hub_labels.graph import (
    ANY_PRICE,
    CORNERS_A_SLICE,
    Contracted,
    Graph,
    Ground,
    Rectangle,
    contract_graph,
    lay_ground,
    link_corners,
    mend_ground,
)
from ppaas.planners.hub_labels.head import fingerprint, seal
from ppaas.planners.hub_labels.importance import Edges, grow_trees, inherit
from ppaas.planners.hub_labels.kernels import layout
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.laying import lay_labels, lay_table, lay_ways
from ppaas.planners.hub_labels.kernels.scan import DIAGONAL, Integers, most_seen
from ppaas.planners.hub_labels.kernels.terrain import COLUMNS, ROWS
from ppaas.planners.hub_labels.kernels.trees import FAR
from ppaas.planners.hub_labels.labels import Pool, label

ENTRIES_A_SLICE = 1 << 17


def build_index(free: NDArray[np.bool_], *, threads: int, check: Callable[[], None]) -> Words:
    """Build the index of a map.

    Parameters
    ----------
    free : (height, width) bool array
        Where a path may lead.
    threads : int
        Most threads that kernels may use.
    check : callable
        Called at least every 10 ms of work.

    Returns
    -------
    int64 array
        As `kernels.layout` has it; read-only.

    Raises
    ------
    InvalidPlanner
        The map is too large or too cluttered for an index.
    """
    ground = lay_ground(free, threads=threads, check=check)
    return seal(_index(ground, ANY_PRICE, None, threads, check), fingerprint(free))


def repair_index(
    index: Words, free: NDArray[np.bool_], changed: Rectangle, *, threads: int, check: Callable[[], None]
) -> Words:
    """Build the index of a map that differs from that of another only in a rectangle.

    What takes longest is to find out how important each corner is. That is kept, and new corners are the least
    important: labels grow if much changes, but the paths are shortest as ever.

    Parameters
    ----------
    index : int64 array
        Of the map before.
    free : (height, width) bool array
        The map now.
    changed : (slice, slice)
        Rows and columns outside of which nothing has changed.
    threads, check
        As for `build_index`.

    Raises
    ------
    InvalidPlanner
        The map is too large or too cluttered for an index.
    """
    terrain = index[index[layout.TERRAIN] : index[layout.TERRAIN + 1]]
    ground = mend_ground(terrain, free, changed, check=check)
    ranks, prices = inherit(index, ground.places)
    return seal(_index(ground, prices, ranks, threads, check), fingerprint(free))


def _index(
    ground: Ground, prices: Integers, inherited: Integers | None, threads: int, check: Callable[[], None]
) -> Words:
    graph = link_corners(ground, threads=threads, check=check)
    contracted = contract_graph(graph, prices, check=check)
    # A hub and an end of a path are so far apart at most, or the length of the path to the corner before would not fit.
    longest = int(FAR - DIAGONAL * (ground.terrain[ROWS] + ground.terrain[COLUMNS]))
    pool = label(contracted, inherited, longest=longest, threads=threads, check=check)
    return _Assembly(ground, graph, contracted, pool).assemble(check)


class _Assembly:
    def __init__(self, ground: Ground, graph: Graph, contracted: Contracted, pool: Pool) -> None:
        self._ground = ground
        self._graph = graph
        self._contracted = contracted
        self._pool = pool
        self._corners = len(ground.places)

    def assemble(self, check: Callable[[], None]) -> Words:
        """Lay all of it into one array."""
        offsets = np.empty(len(self._contracted.after), np.int32)
        check()
        table = self._table(offsets)
        landmarks = self._landmarks(check)
        sizes = {
            layout.TERRAIN: 2 * len(self._ground.terrain), layout.TABLE: len(table),
            layout.LANDMARKS: landmarks.size, layout.LABELS: int(table[-layout.CORNER_SIZE + layout.LABEL]),
            layout.WAYS: int(table[-layout.CORNER_SIZE + layout.WAY]), layout.RANKS: self._corners + 1,
        }  # fmt: skip
        index = _room(sizes)
        self._tell_sizes(index, landmarks)
        for section, content in (
            (layout.TERRAIN, self._ground.terrain.view(np.int32)), (layout.TABLE, table),
            (layout.LANDMARKS, landmarks.ravel()), (layout.RANKS, self._pool.ranks),
        ):  # fmt: skip
            check()
            _integers(index, section)[: len(content)] = content
        _integers(index, layout.RANKS)[self._corners] = len(self._contracted.order)
        self._lay_ways(index, table, check)
        self._lay_labels(index, table, offsets, check)
        return index

    def _table(self, offsets: Integers) -> Integers:
        contracted, pool = self._contracted, self._pool
        table = np.zeros((self._corners + 1) * layout.CORNER_SIZE, np.int32)
        most_ways = lay_table(
            self._ground.places, pool.ranks, pool.begins, pool.ends,
            contracted.head, contracted.after, contracted.edges, table, offsets,
        )  # fmt: skip
        entries = pool.ends - pool.begins
        too_many = 3 * int(entries.sum()) > np.iinfo(np.int32).max
        if too_many or most_ways > layout.MOST_WAYS or int(entries.max(initial=0)) > layout.PLACE_BITS:
            raise InvalidPlanner("the map is too cluttered for an index of hub labels; choose another planner")
        return table

    def _tell_sizes(self, index: Words, landmarks: Integers) -> None:
        terrain = self._ground.terrain
        index[layout.CORNERS] = self._corners
        index[layout.MOST_SEEN] = most_seen(int(terrain[ROWS]), int(terrain[COLUMNS]), self._corners)
        index[layout.LANDMARK_COUNT] = landmarks.shape[1]

    def _landmarks(self, check: Callable[[], None]) -> Integers:
        """Return how far each corner is from the landmarks: each is the corner farthest from those before it."""
        corners, graph = self._corners, self._graph
        if graph.is_cluttered or corners == 0:  # it takes no landmarks to tell few corners apart
            return np.empty((corners, 0), np.int32)
        edges = Edges(graph.starts, graph.to, graph.lengths, graph.to)
        landmarks = np.empty((corners, layout.MARKS), np.int32)
        nearest = np.full(corners, FAR, np.int32)
        landmark = int(self._pool.ranks.argmin())
        for mark in range(-1, layout.MARKS):
            root = np.array([landmark], np.int32)
            _, lengths = grow_trees(edges, root, sizes=False, slots=1, threads=1, check=check)
            if mark < 0:
                nearest[lengths[0] == FAR] = -1  # what cannot be reached from the best hub is no landmark
                landmark = int(np.where(nearest < 0, -1, lengths[0]).argmax())
                continue
            landmarks[:, mark] = lengths[0]
            nearest = np.minimum(nearest, lengths[0])
            landmark = int(nearest.argmax())
        return landmarks

    def _lay_ways(self, index: Words, table: Integers, check: Callable[[], None]) -> None:
        contracted, ways = self._contracted, _integers(index, layout.WAYS)
        for first in range(0, self._corners, CORNERS_A_SLICE):
            check()
            last = min(first + CORNERS_A_SLICE, self._corners)
            lay_ways(table, first, last, contracted.head, contracted.after, contracted.edges, ways)

    def _lay_labels(self, index: Words, table: Integers, offsets: Integers, check: Callable[[], None]) -> None:
        pool, labels = self._pool, _integers(index, layout.LABELS)
        corners = max(1, ENTRIES_A_SLICE * self._corners // max(1, len(labels)))
        for first in range(0, self._corners, corners):
            check()
            last = min(first + corners, self._corners)
            lay_labels(
                table, first, last, pool.ranks, self._contracted.edges, offsets,
                pool.hubs, pool.lengths, pool.towards, pool.begins, pool.ends, labels,
            )  # fmt: skip


def _room(sizes: dict[int, int]) -> Words:
    """Return an index with room for sections of so many int32 each."""
    words = [(sizes[section] + 1) // 2 for section in range(layout.TERRAIN, layout.END)]
    begins = layout.HEAD + np.cumsum([0, *words])
    index = np.zeros(begins[-1], np.int64)
    index[layout.TERRAIN : layout.END + 1] = begins
    return index


def _integers(index: Words, section: int) -> Integers:
    return index.view(np.int32)[2 * index[section] : 2 * index[section + 1]]
