"""Kernel: pack labels and paths as `layout` describes: by rank of the corners, and with shortcuts expanded."""

import numpy as np

from ppaas.kernel_cache.decorators import bare, compiled, joined
from ppaas.planners.hub_labels.building.kernels.contraction import LEFT, LENGTH, RIGHT, RUNS, TO
from ppaas.planners.hub_labels.building.kernels.trees import Rows
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.layout import (
    COLUMN,
    CORNER_SIZE,
    DIRECTIONS,
    ENTRIES,
    FRINGE_HEAD,
    GATE_COUNT,
    LABEL,
    LAST,
    LINK_NEXT,
    LINK_PATH,
    LINK_SIZE,
    MOST_MOVES,
    ROW,
    Shorts,
    edges_after,
    fringe_size,
    label_size,
    lengths_after,
    links_after,
)
from ppaas.planners.hub_labels.kernels.path_cells import direction_of
from ppaas.planners.hub_labels.kernels.scan import Integers


@bare
def pack_table(
    positions: Rows, ranks: Integers, begins: Words, ends: Words, labelled: int, gates: Words,
    head: Integers, after: Integers, edges: Rows, table: Rows, offsets: Integers, sizes: Words,
) -> None:  # fmt: skip
    """Write the table of corners, and compute the sizes of labels and paths.

    Parameters
    ----------
    positions : (n, 2) int32 array
        Row and column of each corner.
    ranks : (n,) int32 array
        Rank of each corner.
    begins, ends : (n,) int64 arrays
        Range of the label of each rank in the pool.
    labelled : int
        Number of labelled corners; the rest is the fringe.
    gates : (n,) int64 array
        Number of gates of each rank.
    head, after, edges
        The contracted graph: first edge of each node, next edge of the same node, and edges as in `contraction`.
    table : (n, 4) int32 array
        Out: the table, by rank.
    offsets : (m,) int32 array
        Out: offset of the path of each edge.
    sizes : (2,) int64 array
        Out: total size of labels [int32] and of paths [uint16]. If one exceeds the range of int32, the other results
        are not usable.
    """
    label, path = np.int64(0), np.int64(0)
    for corner in range(len(ranks)):
        rank = ranks[corner]
        table[rank, ROW] = positions[corner, 0]
        table[rank, COLUMN] = positions[corner, 1]
        table[rank, LABEL] = label
        edge, count = head[corner], 0
        while edge >= 0:
            offsets[edge] = path
            path += edges[edge, RUNS]
            edge = after[edge]
            count += 1
        entries = ends[rank] - begins[rank] if rank < labelled else -1 - count
        table[rank, ENTRIES] = entries
        label += label_size(entries) if entries >= 0 else fringe_size(count, gates[rank])
    sizes[0] = label
    sizes[1] = path


@bare
def _index_of(hub: int, hubs: Integers, begin: int, end: int) -> int:
    """Return the index of a hub in a label by binary search."""
    low, high = begin, end - 1
    while low < high:
        middle = (low + high) >> 1
        if hubs[middle] < hub:
            low = middle + 1
        else:
            high = middle
    return low - begin


@bare
def pack_fringe(
    table: Rows, first: int, last: int, ranks: Integers,
    head: Integers, after: Integers, edges: Rows, offsets: Integers,
    gates: Integers, lengths: Integers, begins: Words, ends: Words, local: Words, boxes: Rows, labels: Integers,
) -> None:  # fmt: skip
    """Write the numbers of those corners from ``first`` to ``last`` that belong to the fringe.

    Parameters
    ----------
    table, ranks, head, after, edges, offsets
        As for `pack_table`.
    first, last : int
        Range of the corners.
    gates, lengths, begins, ends, local, boxes
        As in `gates.find_gates`, but with ``local`` by edge number.
    labels : int32 array
        Out: the section of labels.
    """
    for corner in range(first, last):
        rank = ranks[corner]
        at, count, begin = table[rank, LABEL], -1 - table[rank, ENTRIES], begins[rank]
        if count < 0:
            continue
        found = ends[rank] - begin
        for side in range(GATE_COUNT):
            labels[at + side] = boxes[rank, side]
        labels[at + GATE_COUNT] = found
        for i in range(found):
            labels[at + FRINGE_HEAD + i] = gates[begin + i]
            labels[at + FRINGE_HEAD + found + i] = lengths[begin + i]
        edge = head[corner]
        for i in range(at + edges_after(found), at + edges_after(found) + count):
            labels[i] = ranks[edges[edge, TO]]
            labels[i + count] = edges[edge, LENGTH] if local[edge] else -edges[edge, LENGTH]
            labels[i + 2 * count] = offsets[edge]
            edge = after[edge]


@bare
def pack_labels(
    table: Rows, first: int, last: int, ranks: Integers, edges: Rows, offsets: Integers,
    hubs: Integers, lengths: Integers, towards: Integers, begins: Words, ends: Words, labels: Integers, short: Shorts,
) -> None:  # fmt: skip
    """Write the labels of those corners from ``first`` to ``last`` that have one.

    Parameters
    ----------
    table, ranks, edges, offsets
        As for `pack_table`.
    first, last : int
        Range of the corners.
    hubs, lengths, towards, begins, ends
        Pool of labels by rank; ``towards`` is the edge towards the hub, −1 in the hub's own label.
    labels : int32 array
        Out: the section of labels.
    short : uint16 array
        View of the same memory.
    """
    for corner in range(first, last):
        rank = ranks[corner]
        at, size, own = table[rank, LABEL], table[rank, ENTRIES], begins[rank]
        if size < 0:
            continue
        if size & 1:
            short[2 * at + size] = 0
        for i in range(size):
            hub, edge = hubs[own + i], towards[own + i]
            link = at + links_after(size) + LINK_SIZE * i
            short[2 * at + i] = hub
            labels[at + lengths_after(size) + i] = lengths[own + i]
            labels[link + LINK_NEXT] = -1
            labels[link + LINK_PATH] = -1 if edge < 0 else offsets[edge]
            if edge >= 0 and ranks[edges[edge, TO]] != hub:
                above = ranks[edges[edge, TO]]
                place = _index_of(hub, hubs, begins[above], ends[above])
                labels[link + LINK_NEXT] = table[above, LABEL] + links_after(table[above, ENTRIES]) + LINK_SIZE * place


@compiled
def pack_paths(
    positions: Rows,
    first: int,
    last: int,
    head: Integers,
    after: Integers,
    edges: Rows,
    offsets: Integers,
    paths: Shorts,
) -> None:
    """Write the paths of the edges of the corners from ``first`` to ``last``.

    Parameters
    ----------
    positions : (n, 2) int32 array
        Row and column of each corner.
    first, last : int
        Range of the corners.
    head, after, edges
        The contracted graph, as for `pack_table`.
    offsets : (m,) int32 array
        Offset of the path of each edge.
    paths : uint16 array
        Out: the section of paths.
    """
    longest = 1
    for corner in range(first, last):
        edge = head[corner]
        while edge >= 0:
            longest = max(longest, edges[edge, RUNS])
            edge = after[edge]
    stack = np.empty(longest + 1, np.int32)
    for corner in range(first, last):
        edge = head[corner]
        while edge >= 0:
            _write_edge(edge, corner, edges, positions, offsets[edge], paths, stack)
            edge = after[edge]


@bare
def _write_edge(
    edge: int, corner: int, edges: Rows, positions: Rows, begin: int, paths: Shorts, stack: Integers
) -> None:
    """Write the runs of an edge, expanding shortcuts with an explicit stack."""
    at = begin
    stack[0] = edge
    depth = 1
    while depth > 0:
        depth -= 1
        part = stack[depth]
        if edges[part, LEFT] >= 0:
            stack[depth] = edges[part, RIGHT]
            stack[depth + 1] = edges[part, LEFT] ^ 1
            depth += 2
            continue
        to = edges[part, TO]
        rows, columns = positions[to, 0] - positions[corner, 0], positions[to, 1] - positions[corner, 1]
        down, right = (rows > 0) - (rows < 0), (columns > 0) - (columns < 0)
        rows, columns = abs(rows), abs(columns)
        diagonal = min(rows, columns)
        at = _write_runs(paths, at, direction_of(down, right), diagonal)
        if rows > columns:
            at = _write_runs(paths, at, direction_of(down, 0), rows - diagonal)
        else:
            at = _write_runs(paths, at, direction_of(0, right), columns - diagonal)
        corner = to
    paths[at - 1] |= LAST


@joined
def _write_runs(paths: Shorts, at: int, direction: int, moves: int) -> int:
    """Write moves in one direction as runs; return the next index."""
    while moves > 0:
        run = min(moves, MOST_MOVES)
        paths[at] = (run << DIRECTIONS) | direction
        moves -= run
        at += 1
    return at


def warm() -> None:
    """Compile and call each kernel once."""
    nothing, starts = np.empty(0, np.int32), np.zeros(2, np.int64)
    positions, edges = np.empty((0, 2), np.int32), np.empty((0, 5), np.int32)
    table, paths = np.empty((0, CORNER_SIZE), np.int32), np.empty(0, np.uint16)
    pack_table(positions, nothing, starts, starts, 0, starts, nothing, nothing, edges, table, nothing, starts)
    pack_labels(table, 0, 0, nothing, edges, nothing, nothing, nothing, nothing, starts, starts, nothing, paths)
    pack_fringe(
        table, 0, 0, nothing, nothing, nothing, edges, nothing,
        nothing, nothing, starts, starts, starts, table, nothing,
    )  # fmt: skip
    pack_paths(positions, 0, 0, nothing, nothing, edges, nothing, paths)
