"""Builds an index: corner map, visibility graph, contraction, labels, and the array that holds all of them."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from ppaas.errors import InvalidPlanner
from ppaas.planners.hub_labels.building.contraction import ANY_COST, Contraction
from ppaas.planners.hub_labels.building.gates import Fringe, find_fringe
from ppaas.planners.hub_labels.building.graph import (
    CORNERS_A_SLICE,
    ContractedGraph,
    CornerGraph,
    CornerMap,
    Rectangle,
    build_corner_graph,
    build_corner_map,
    repair_corner_map,
)
from ppaas.planners.hub_labels.building.header import fingerprint, seal
from ppaas.planners.hub_labels.building.importance import edges_of, inherit
from ppaas.planners.hub_labels.building.kernels.packing import pack_fringe, pack_labels, pack_paths, pack_table
from ppaas.planners.hub_labels.building.kernels.pool_distances import lengths_from
from ppaas.planners.hub_labels.building.labels import LabelPool, label
from ppaas.planners.hub_labels.building.size_limits import (
    BYTES_AN_ENTRY,
    LEAST_ENTRIES,
    is_dense,
    most_bytes,
    most_edge_visits,
    most_edges,
    most_label_entries,
    too_dense,
)
from ppaas.planners.hub_labels.kernels import layout
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.layout import FAR, Shorts
from ppaas.planners.hub_labels.kernels.scan import DIAGONAL, Integers, most_seen
from ppaas.planners.hub_labels.kernels.terrain import COLUMNS, ROWS

ENTRIES_A_SLICE = 1 << 17
"""Label entries written between two calls of ``check``."""

MANY_GATES = 6
"""Mean number of gates of a corner from which landmarks exclude enough of them to pay off."""

DENSE_CORE_CORNERS = 4000, 12000
"""Largest core of a dense map [corners], without and with spare memory; label sizes grow with it."""

LABEL_ENTRIES, SHORTCUT_ENTRIES = 160, 62
"""Largest label of a corner of the smallest core [entries], and the label memory that the shortcuts of each further
contracted corner take [entries]."""


def build_index(free: NDArray[np.bool_], *, threads: int, check: Callable[[], None]) -> Words:
    """Build the index of a map.

    Parameters
    ----------
    free : (height, width) bool array
        Free cells.
    threads : int
        Maximum number of threads for kernels.
    check : callable
        Called at least every 10 ms of work; may raise to cancel it.

    Returns
    -------
    int64 array
        The index, laid out as `kernels.layout` describes; read-only.

    Raises
    ------
    InvalidPlanner
        The map is too large or too cluttered for an index.
    """
    corner_map = build_corner_map(free, threads=threads, check=check)
    return seal(_index(corner_map, ANY_COST, None, threads, check), fingerprint(free))


def repair_index(
    index: Words, free: NDArray[np.bool_], changed: Rectangle, *, threads: int, check: Callable[[], None]
) -> Words:
    """Build the index of a map from the index of a map that differs only in a rectangle.

    Ordering corners by importance takes the most time. The order is kept, and new corners become the least important.
    Labels grow if much changes, but paths stay shortest.

    Parameters
    ----------
    index : int64 array
        Index of the earlier map.
    free : (height, width) bool array
        Free cells of the current map.
    changed : (slice, slice)
        Rows and columns that contain all changes.
    threads, check
        As for `build_index`.

    Raises
    ------
    InvalidPlanner
        The map is too large or too cluttered for an index.
    """
    terrain = index[index[layout.TERRAIN] : index[layout.TERRAIN + 1]]
    corner_map = repair_corner_map(terrain, free, changed, check=check)
    ranks, costs = inherit(index, corner_map.positions)
    return seal(_index(corner_map, costs, ranks, threads, check), fingerprint(free))


def _index(
    corner_map: CornerMap, costs: Integers, inherited: Integers | None, threads: int, check: Callable[[], None]
) -> Words:
    graph = build_corner_graph(corner_map, threads=threads, check=check)
    dense = is_dense(corner_map, graph)
    contraction = Contraction(
        graph, costs,
        thorough=dense, most_edges=most_edges(corner_map, graph), most_edge_visits=most_edge_visits(corner_map),
        threads=threads,
    )  # fmt: skip
    contracted = _contracted(contraction, corner_map, dense, check)
    # Limit of lengths in labels: a length plus the length of an edge stays below `FAR`.
    longest = int(FAR - DIAGONAL * (corner_map.terrain[ROWS] + corner_map.terrain[COLUMNS]))
    excess = 0
    while not contraction.is_given_up:
        most_entries = most_label_entries(corner_map, contracted) - excess
        if most_entries < LEAST_ENTRIES * len(corner_map.positions):
            break
        pool = label(contracted, inherited, most_entries=most_entries, longest=longest, threads=threads, check=check)
        if pool is None:
            contracted = contraction.run(contraction.core // 2, check=check)
            continue
        fringe = _fringe_of(corner_map, contracted, pool, threads, check)
        index = _IndexWriter(corner_map, graph, contracted, pool, fringe).assemble(check)
        if index.nbytes <= most_bytes(corner_map):
            return index
        # Twice the excess: fewer labels mean more gates.
        excess += 2 * int(index.nbytes - most_bytes(corner_map)) // BYTES_AN_ENTRY + 1
    raise too_dense(corner_map)


def _contracted(
    contraction: Contraction, corner_map: CornerMap, dense: bool, check: Callable[[], None]
) -> ContractedGraph:
    """Contract a graph until all core corners may have labels and their memory suffices, or until it is given up."""
    contracted, most = contraction.run(check=check), layout.MOST_HUBS
    if contraction.is_given_up:
        return contracted
    if dense:
        most = min(most, _dense_core_size(corner_map, most_label_entries(corner_map, contracted), contraction.core))
    return contraction.run(most, check=check) if contraction.core > most else contracted


def _dense_core_size(corner_map: CornerMap, most_entries: int, before: int) -> int:
    """Return the size of the core of a dense map for which label memory suffices, given the size ``before``."""
    least, most = DENSE_CORE_CORNERS
    core = (most_entries - SHORTCUT_ENTRIES * before) // (LABEL_ENTRIES - SHORTCUT_ENTRIES)
    if core < 0 and before > least:
        raise too_dense(corner_map)
    return min(most, max(least, core))


def _fringe_of(
    corner_map: CornerMap, contracted: ContractedGraph, pool: LabelPool, threads: int, check: Callable[[], None]
) -> Fringe:
    nodes = np.argsort(pool.ranks).astype(np.int32)
    edges = edges_of(contracted, nodes, pool.ranks)
    return find_fringe(pool, edges, contracted.levels[nodes], corner_map.positions[nodes], threads=threads, check=check)


class _IndexWriter:
    def __init__(
        self, corner_map: CornerMap, graph: CornerGraph, contracted: ContractedGraph, pool: LabelPool, fringe: Fringe
    ) -> None:
        self._corner_map = corner_map
        self._graph = graph
        self._contracted = contracted
        self._pool = pool
        self._fringe = fringe
        self._corners = len(corner_map.positions)

    def assemble(self, check: Callable[[], None]) -> Words:
        """Return the index as one array."""
        offsets = np.empty(len(self._contracted.after), np.int32)
        check()
        table, (labels, paths) = self._table(offsets)
        landmarks = self._landmarks(check)
        index = _empty_index({
            layout.TERRAIN: self._corner_map.terrain.nbytes, layout.TABLE: table.nbytes,
            layout.LANDMARKS: landmarks.nbytes, layout.LABELS: 4 * labels, layout.PATHS: 2 * paths,
            layout.RANKS: 4 * (self._corners + 1),
        })  # fmt: skip
        self._write_header(index, landmarks)
        for section, content in (
            (layout.TERRAIN, self._corner_map.terrain), (layout.TABLE, table), (layout.LANDMARKS, landmarks),
            (layout.RANKS, self._pool.ranks),
        ):  # fmt: skip
            check()
            _section(index, section, content.dtype)[: content.size] = content.ravel()
        _section(index, layout.RANKS, np.int32)[self._corners] = len(self._contracted.order)
        self._pack_paths(_section(index, layout.PATHS, np.uint16), offsets, check)
        self._pack_labels(_section(index, layout.LABELS, np.int32), table, offsets, check)
        return index

    def _table(self, offsets: Integers) -> tuple[Integers, tuple[int, int]]:
        contracted, pool = self._contracted, self._pool
        table, sizes = np.empty((self._corners, layout.CORNER_SIZE), np.int32), np.zeros(2, np.int64)
        pack_table(
            self._corner_map.positions, pool.ranks, pool.begins, pool.ends, pool.labelled,
            self._fringe.ends - self._fringe.begins,
            contracted.head, contracted.after, contracted.edges, table, offsets, sizes,
        )  # fmt: skip
        if int(sizes.max()) > np.iinfo(np.int32).max:
            raise InvalidPlanner(
                "the map is too cluttered for an index of hub labels; choose another planner, such as jps or dijkstra"
            )
        return table, (int(sizes[0]), int(sizes[1]))

    def _write_header(self, index: Words, landmarks: Integers) -> None:
        terrain = self._corner_map.terrain
        labelled = self._pool.labelled
        seen = most_seen(int(terrain[ROWS]), int(terrain[COLUMNS]), self._corners)
        index[layout.CORNERS], index[layout.LABELLED] = self._corners, labelled
        # Through the fringe, an end may reach every labelled corner.
        index[layout.MOST_SEEN] = seen if labelled == self._corners else max(seen, labelled)
        index[layout.LANDMARK_COUNT] = landmarks.shape[1]

    def _landmarks(self, check: Callable[[], None]) -> Integers:
        """Return the distances of each labelled corner to the landmarks.

        Landmarks are chosen farthest first: each is the corner farthest from the earlier ones (Goldberg and Harrelson,
        2005).
        """
        pool, labelled = self._pool, self._pool.labelled
        if labelled == 0 or (self._graph.is_cluttered and not self._has_many_gates()):
            return np.empty((labelled, 0), np.int32)  # landmarks do not pay off for few corners
        of_root, landmarks = np.full(labelled, FAR, np.int32), np.empty((layout.LANDMARK_LANES, labelled), np.int32)
        far = np.empty(labelled, np.int32)
        labels_and_scratch = pool.hubs, pool.lengths, pool.begins, pool.ends, of_root
        lengths_from(0, labelled, *labels_and_scratch, far)
        nearest = np.where(far < FAR, FAR, -1)  # corners that the best hub cannot reach are no landmarks
        landmark = int(np.where(nearest < 0, -1, far).argmax())
        for own in landmarks:
            check()
            lengths_from(landmark, labelled, *labels_and_scratch, own)
            nearest = np.minimum(nearest, own)
            landmark = int(nearest.argmax())
        return np.minimum(landmarks, FAR).T.copy()

    def _has_many_gates(self) -> bool:
        fringe = self._corners - self._pool.labelled
        return int((self._fringe.ends - self._fringe.begins).sum()) > MANY_GATES * fringe > 0

    def _pack_paths(self, paths: Shorts, offsets: Integers, check: Callable[[], None]) -> None:
        contracted, positions = self._contracted, self._corner_map.positions
        for first in range(0, self._corners, CORNERS_A_SLICE):
            check()
            last = min(first + CORNERS_A_SLICE, self._corners)
            pack_paths(positions, first, last, contracted.head, contracted.after, contracted.edges, offsets, paths)

    def _pack_labels(self, labels: Integers, table: Integers, offsets: Integers, check: Callable[[], None]) -> None:
        pool, graph, fringe, short = self._pool, self._contracted, self._fringe, labels.view(np.uint16)
        corners = max(1, ENTRIES_A_SLICE * self._corners // max(1, len(labels)))
        for first in range(0, self._corners, corners):
            check()
            last = min(first + corners, self._corners)
            pack_labels(
                table, first, last, pool.ranks, graph.edges, offsets,
                pool.hubs, pool.lengths, pool.towards, pool.begins, pool.ends, labels, short,
            )  # fmt: skip
            pack_fringe(
                table, first, last, pool.ranks, graph.head, graph.after, graph.edges, offsets,
                fringe.gates, fringe.lengths, fringe.begins, fringe.ends, fringe.local, fringe.boxes, labels,
            )  # fmt: skip


def _empty_index(sizes: dict[int, int]) -> Words:
    """Return an index with space for sections of these sizes [bytes]."""
    words = [(sizes[section] + 7) // 8 for section in range(layout.TERRAIN, layout.END)]
    begins = layout.HEAD + np.cumsum([0, *words])
    index = np.zeros(begins[-1], np.int64)
    index[layout.TERRAIN : layout.END + 1] = begins
    return index


def _section(index: Words, section: int, kind: DTypeLike) -> NDArray[Any]:
    return index[index[section] : index[section + 1]].view(kind)
