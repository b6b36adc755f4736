"""Builds an index: ground, graph, contraction, labels, and all of it laid into one array."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from ppaas.errors import InvalidPlanner
from ppaas.planners.hub_labels.building.contraction import ANY_COST, Contraction
from ppaas.planners.hub_labels.building.gates import Fringe, open_fringe
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
from ppaas.planners.hub_labels.building.kernels.packing import lay_fringe, lay_labels, lay_table, lay_ways
from ppaas.planners.hub_labels.building.kernels.pool_distances import tell_lengths
from ppaas.planners.hub_labels.building.label_pool import LabelPool
from ppaas.planners.hub_labels.building.labels import label
from ppaas.planners.hub_labels.building.size_limits import (
    BYTES_AN_ENTRY,
    LEAST_ENTRIES,
    is_crowded,
    most_bytes,
    most_edges,
    most_label_entries,
    most_scans,
    too_crowded,
)
from ppaas.planners.hub_labels.kernels import layout
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.layout import FAR, Shorts
from ppaas.planners.hub_labels.kernels.scan import DIAGONAL, Integers, most_seen
from ppaas.planners.hub_labels.kernels.terrain import COLUMNS, ROWS

ENTRIES_A_SLICE = 1 << 17

MANY_GATES = 6
"""Gates of a corner in the mean, from which on landmarks leave enough of them out."""

CORE_IN_A_CROWD = 4000, 12000
"""Corners that a core may have on a crowded map, by how much room there is: labels grow with it."""

ENTRIES_A_CORNER, ENTRIES_FOR_SHORTCUTS = 160, 62
"""Entries of the label of one of so many, at most, and for how many there is no room any more for each corner that is
contracted: the core has room then."""


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
    ground = build_corner_map(free, threads=threads, check=check)
    return seal(_index(ground, ANY_COST, None, threads, check), fingerprint(free))


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
    ground = repair_corner_map(terrain, free, changed, check=check)
    ranks, prices = inherit(index, ground.places)
    return seal(_index(ground, prices, ranks, threads, check), fingerprint(free))


def _index(
    ground: CornerMap, prices: Integers, inherited: Integers | None, threads: int, check: Callable[[], None]
) -> Words:
    graph = build_corner_graph(ground, threads=threads, check=check)
    crowded = is_crowded(ground, graph)
    contraction = Contraction(
        graph, prices,
        thorough=crowded, most_edges=most_edges(ground, graph), most_scans=most_scans(ground), threads=threads,
    )  # fmt: skip
    contracted = _contracted(contraction, ground, crowded, check)
    # A hub and an end of a path are so far apart at most, or the length of the path to the corner before would not fit.
    longest = int(FAR - DIAGONAL * (ground.terrain[ROWS] + ground.terrain[COLUMNS]))
    excess = 0
    while not contraction.is_given_up:
        room = most_label_entries(ground, contracted) - excess
        if room < LEAST_ENTRIES * len(ground.places):
            break
        pool = label(contracted, inherited, room=room, longest=longest, threads=threads, check=check)
        if pool is None:
            contracted = contraction.run(contraction.core // 2, check=check)
            continue
        fringe = _fringe_of(ground, contracted, pool, threads, check)
        index = _Assembly(ground, graph, contracted, pool, fringe).assemble(check)
        if index.nbytes <= most_bytes(ground):
            return index
        # Twice what is too much, as fewer labels leave more gates.
        excess += 2 * int(index.nbytes - most_bytes(ground)) // BYTES_AN_ENTRY + 1
    raise too_crowded(ground)


def _contracted(
    contraction: Contraction, ground: CornerMap, crowded: bool, check: Callable[[], None]
) -> ContractedGraph:
    """Contract a graph until all of its core may have labels, and there is room for them; or until it is given up."""
    contracted, most = contraction.run(check=check), layout.MOST_HUBS
    if contraction.is_given_up:
        return contracted
    if crowded:
        most = min(most, _core_in_a_crowd(ground, most_label_entries(ground, contracted), contraction.core))
    return contraction.run(most, check=check) if contraction.core > most else contracted


def _core_in_a_crowd(ground: CornerMap, room: int, before: int) -> int:
    """Return how many corners of a core are left, of so many, for those to have room for their labels then."""
    least, most = CORE_IN_A_CROWD
    core = (room - ENTRIES_FOR_SHORTCUTS * before) // (ENTRIES_A_CORNER - ENTRIES_FOR_SHORTCUTS)
    if core < 0 and before > least:
        raise too_crowded(ground)
    return min(most, max(least, core))


def _fringe_of(
    ground: CornerMap, contracted: ContractedGraph, pool: LabelPool, threads: int, check: Callable[[], None]
) -> Fringe:
    nodes = np.argsort(pool.ranks).astype(np.int32)
    edges = edges_of(contracted, nodes, pool.ranks)
    return open_fringe(pool, edges, contracted.levels[nodes], ground.places[nodes], threads=threads, check=check)


class _Assembly:
    def __init__(
        self, ground: CornerMap, graph: CornerGraph, contracted: ContractedGraph, pool: LabelPool, fringe: Fringe
    ) -> None:
        self._ground = ground
        self._graph = graph
        self._contracted = contracted
        self._pool = pool
        self._fringe = fringe
        self._corners = len(ground.places)

    def assemble(self, check: Callable[[], None]) -> Words:
        """Lay all of it into one array."""
        offsets = np.empty(len(self._contracted.after), np.int32)
        check()
        table, (labels, ways) = self._table(offsets)
        landmarks = self._landmarks(check)
        index = _room({
            layout.TERRAIN: self._ground.terrain.nbytes, layout.TABLE: table.nbytes,
            layout.LANDMARKS: landmarks.nbytes, layout.LABELS: 4 * labels, layout.WAYS: 2 * ways,
            layout.RANKS: 4 * (self._corners + 1),
        })  # fmt: skip
        self._tell_sizes(index, landmarks)
        for section, content in (
            (layout.TERRAIN, self._ground.terrain), (layout.TABLE, table), (layout.LANDMARKS, landmarks),
            (layout.RANKS, self._pool.ranks),
        ):  # fmt: skip
            check()
            _part(index, section, content.dtype)[: content.size] = content.ravel()
        _part(index, layout.RANKS, np.int32)[self._corners] = len(self._contracted.order)
        self._lay_ways(_part(index, layout.WAYS, np.uint16), offsets, check)
        self._lay_labels(_part(index, layout.LABELS, np.int32), table, offsets, check)
        return index

    def _table(self, offsets: Integers) -> tuple[Integers, tuple[int, int]]:
        contracted, pool = self._contracted, self._pool
        table, sizes = np.empty((self._corners, layout.CORNER_SIZE), np.int32), np.zeros(2, np.int64)
        lay_table(
            self._ground.places, pool.ranks, pool.begins, pool.ends, pool.labelled,
            self._fringe.ends - self._fringe.begins,
            contracted.head, contracted.after, contracted.edges, table, offsets, sizes,
        )  # fmt: skip
        if int(sizes.max()) > np.iinfo(np.int32).max:
            raise InvalidPlanner("the map is too cluttered for an index of hub labels; choose another planner")
        return table, (int(sizes[0]), int(sizes[1]))

    def _tell_sizes(self, index: Words, landmarks: Integers) -> None:
        terrain = self._ground.terrain
        labelled = self._pool.labelled
        seen = most_seen(int(terrain[ROWS]), int(terrain[COLUMNS]), self._corners)
        index[layout.CORNERS], index[layout.LABELLED] = self._corners, labelled
        # Over the fringe, every corner that has a label may be reached.
        index[layout.MOST_SEEN] = seen if labelled == self._corners else max(seen, labelled)
        index[layout.LANDMARK_COUNT] = landmarks.shape[1]

    def _landmarks(self, check: Callable[[], None]) -> Integers:
        """Return how far each corner with a label is from the landmarks.

        Each landmark is the corner farthest from those before it.
        """
        pool, labelled = self._pool, self._pool.labelled
        if labelled == 0 or (self._graph.is_cluttered and not self._has_many_gates()):
            return np.empty((labelled, 0), np.int32)  # it takes no landmarks to tell few corners apart
        of_root, landmarks = np.full(labelled, FAR, np.int32), np.empty((layout.MARKS, labelled), np.int32)
        far = np.empty(labelled, np.int32)
        tell = pool.hubs, pool.lengths, pool.begins, pool.ends, of_root
        tell_lengths(0, labelled, *tell, far)
        nearest = np.where(far < FAR, FAR, -1)  # what cannot be reached from the best hub is no landmark
        landmark = int(np.where(nearest < 0, -1, far).argmax())
        for own in landmarks:
            check()
            tell_lengths(landmark, labelled, *tell, own)
            nearest = np.minimum(nearest, own)
            landmark = int(nearest.argmax())
        return np.minimum(landmarks, FAR).T.copy()

    def _has_many_gates(self) -> bool:
        fringe = self._corners - self._pool.labelled
        return int((self._fringe.ends - self._fringe.begins).sum()) > MANY_GATES * fringe > 0

    def _lay_ways(self, ways: Shorts, offsets: Integers, check: Callable[[], None]) -> None:
        contracted, places = self._contracted, self._ground.places
        for first in range(0, self._corners, CORNERS_A_SLICE):
            check()
            last = min(first + CORNERS_A_SLICE, self._corners)
            lay_ways(places, first, last, contracted.head, contracted.after, contracted.edges, offsets, ways)

    def _lay_labels(self, labels: Integers, table: Integers, offsets: Integers, check: Callable[[], None]) -> None:
        pool, graph, fringe, short = self._pool, self._contracted, self._fringe, labels.view(np.uint16)
        corners = max(1, ENTRIES_A_SLICE * self._corners // max(1, len(labels)))
        for first in range(0, self._corners, corners):
            check()
            last = min(first + corners, self._corners)
            lay_labels(
                table, first, last, pool.ranks, graph.edges, offsets,
                pool.hubs, pool.lengths, pool.towards, pool.begins, pool.ends, labels, short,
            )  # fmt: skip
            lay_fringe(
                table, first, last, pool.ranks, graph.head, graph.after, graph.edges, offsets,
                fringe.gates, fringe.lengths, fringe.begins, fringe.ends, fringe.local, fringe.boxes, labels,
            )  # fmt: skip


def _room(sizes: dict[int, int]) -> Words:
    """Return an index with room for sections of so many bytes each."""
    words = [(sizes[section] + 7) // 8 for section in range(layout.TERRAIN, layout.END)]
    begins = layout.HEAD + np.cumsum([0, *words])
    index = np.zeros(begins[-1], np.int64)
    index[layout.TERRAIN : layout.END + 1] = begins
    return index


def _part(index: Words, section: int, kind: DTypeLike) -> NDArray[Any]:
    return index[index[section] : index[section + 1]].view(kind)
