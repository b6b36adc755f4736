"""Builds an index: ground, graph, contraction, labels, and all of it laid into one array."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidPlanner
from ppaas.planners.hub_labels.graph import (
    CORNERS_A_SLICE,
    Contracted,
    Graph,
    Ground,
    contract_graph,
    lay_ground,
    link_corners,
)
from ppaas.planners.hub_labels.head import fingerprint, seal
from ppaas.planners.hub_labels.importance import Edges, grow_trees
from ppaas.planners.hub_labels.kernels import layout
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.laying import MOST_LINKED, count_edges, lay_edges, lay_labels
from ppaas.planners.hub_labels.kernels.scan import DIAGONAL, Integers, most_seen
from ppaas.planners.hub_labels.kernels.terrain import COLUMNS, ROWS
from ppaas.planners.hub_labels.kernels.trees import FAR
from ppaas.planners.hub_labels.labels import Pool, label

_INT32 = (layout.PLACES, layout.LANDMARKS, layout.HUBS, layout.LENGTHS, layout.LINKS, layout.STEPS, layout.RANKS)


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
    graph = link_corners(ground, threads=threads, check=check)
    contracted = contract_graph(graph, check=check)
    longest = int(FAR) - DIAGONAL * sum(free.shape)  # a hub and an end of a path are so far apart at most
    pool = label(contracted, longest=longest, threads=threads, check=check)
    index = _Assembly(ground, graph, contracted, pool).assemble(threads, check)
    return seal(index, fingerprint(free))


class _Assembly:
    def __init__(self, ground: Ground, graph: Graph, contracted: Contracted, pool: Pool) -> None:
        self._ground = ground
        self._graph = graph
        self._contracted = contracted
        self._pool = pool
        self._corners = len(ground.places)

    def assemble(self, threads: int, check: Callable[[], None]) -> Words:
        """Lay all of it into one array."""
        places = np.empty(len(self._contracted.after), np.int32)
        edges = np.zeros(self._corners + 1, np.int64)
        graph = self._contracted.head, self._contracted.after, self._contracted.edges
        check()
        steps = count_edges(*graph, edges, places)
        labels = self._label_begins()
        self._refuse_what_no_link_can_tell(edges)
        index = self._room(int(edges[-1]), steps, int(labels[-1]))
        _words(index, layout.TERRAIN)[:] = self._ground.terrain
        _integers(index, layout.PLACES)[: 2 * self._corners] = self._ground.places.ravel()
        _words(index, layout.LABELS)[:] = labels
        _words(index, layout.EDGES)[:] = edges
        self._lay_ranks(index)
        self._lay_landmarks(index, threads, check)
        self._lay_edges(index, check)
        self._lay_labels(index, places, check)
        return index

    def _label_begins(self) -> Words:
        sizes = (self._pool.ends - self._pool.begins)[self._pool.ranks]
        return np.concatenate((np.zeros(1, np.int64), np.cumsum(sizes)))

    def _refuse_what_no_link_can_tell(self, edges: Words) -> None:
        if self._corners == 0:
            return
        widest = int((self._pool.ends - self._pool.begins).max())
        if int(np.diff(edges).max()) > MOST_LINKED or widest > 2 * MOST_LINKED:
            raise InvalidPlanner("the map is too cluttered for an index of hub labels; choose another planner")

    def _room(self, edges: int, steps: int, entries: int) -> Words:
        corners, terrain = self._corners, self._ground.terrain
        sizes = {
            layout.TERRAIN: len(terrain), layout.PLACES: 2 * corners,
            layout.LANDMARKS: layout.LANDMARK_COUNT * corners, layout.LABELS: corners + 1, layout.EDGES: corners + 1,
            layout.WAYS: edges + 1, layout.HUBS: entries, layout.LENGTHS: entries, layout.LINKS: entries,
            layout.STEPS: steps, layout.RANKS: corners + 1,
        }  # fmt: skip
        words = [(sizes[s] + 1) // 2 if s in _INT32 else sizes[s] for s in range(layout.TERRAIN, layout.END)]
        begins = layout.HEAD + np.cumsum([0, *words])
        index = np.zeros(begins[-1], np.int64)
        index[layout.TERRAIN : layout.END + 1] = begins
        index[layout.CORNERS] = corners
        index[layout.MOST_SEEN] = most_seen(int(terrain[ROWS]), int(terrain[COLUMNS]), corners)
        return index

    def _lay_ranks(self, index: Words) -> None:
        ranks = _integers(index, layout.RANKS)
        ranks[: self._corners] = self._pool.ranks
        ranks[self._corners] = len(self._contracted.order)

    def _lay_landmarks(self, index: Words, threads: int, check: Callable[[], None]) -> None:
        landmarks = _integers(index, layout.LANDMARKS)
        if self._corners == 0:
            return
        edges = Edges(self._graph.starts, self._graph.to, self._graph.lengths, self._graph.to)
        first = np.flatnonzero(self._pool.ranks == 0).astype(np.int32)
        _, lengths = grow_trees(edges, first, sizes=False, slots=1, threads=1, check=check)
        reached = np.flatnonzero(lengths[0] < FAR)
        rows, columns = self._ground.places[reached].T
        sides = (rows, columns, rows + columns, rows - columns)
        farthest = np.array([reached[side.argmax()] for side in sides] + [reached[side.argmin()] for side in sides])
        _, lengths = grow_trees(
            edges, farthest.astype(np.int32), sizes=False, slots=len(farthest), threads=threads, check=check
        )
        landmarks[: lengths.size] = lengths.T.ravel()

    def _lay_edges(self, index: Words, check: Callable[[], None]) -> None:
        ways = _words(index, layout.WAYS)
        ways[0] = 0
        graph = self._contracted.head, self._contracted.after, self._contracted.edges
        for first in range(0, self._corners, CORNERS_A_SLICE):
            check()
            last = min(first + CORNERS_A_SLICE, self._corners)
            edges, steps = _words(index, layout.EDGES), _integers(index, layout.STEPS)
            lay_edges(*graph, edges, first, last, ways, steps)

    def _lay_labels(self, index: Words, places: Integers, check: Callable[[], None]) -> None:
        pool = self._pool
        begins = _words(index, layout.LABELS)
        hubs, lengths, links = (_integers(index, s) for s in (layout.HUBS, layout.LENGTHS, layout.LINKS))
        for first in range(0, self._corners, CORNERS_A_SLICE):
            check()
            last = min(first + CORNERS_A_SLICE, self._corners)
            lay_labels(
                pool.ranks, first, last, self._contracted.edges, places,
                pool.hubs, pool.lengths, pool.towards, pool.begins, pool.ends, begins, hubs, lengths, links,
            )  # fmt: skip


def _words(index: Words, section: int) -> Words:
    return index[index[section] : index[section + 1]]


def _integers(index: Words, section: int) -> Integers:
    return index.view(np.int32)[2 * index[section] : 2 * index[section + 1]]
