"""Kernel: find the gates of fringe corners: the labelled corners through which shortest paths leave the fringe.

Gates are called access nodes in the literature (Bast, Funke, Sanders and Schultes, "Fast Routing in Road Networks with
Transit Nodes", Science 2007). Each fringe corner has edges to more important corners only. The labelled corners that it
reaches upwards are its gates, except for those with another gate on the shortest path to them. So a shortest path
between two corners that touches a labelled corner contains a gate of each of them.

Paths that touch no labelled corner are found by upward searches. For these, an edge between two fringe corners is
*local* unless a path through a gate of both is as short. Each corner has the bounding rectangle of the corners that it
reaches over local edges faster than over any gate. Two ends can meet below all labels only if their rectangles
intersect.
"""

import numpy as np
from numba import prange

from ppaas.kernel_cache.decorators import bare, compiled
from ppaas.kernel_threads import limit_threads
from ppaas.planners.hub_labels.building.kernels.pool_distances import clear, length_up_to, scatter
from ppaas.planners.hub_labels.building.kernels.trees import Heaps, Rows
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.heap import NODE, pop, push
from ppaas.planners.hub_labels.kernels.layout import BOTTOM, FAR, HUB_BITS, LEFTMOST, RIGHTMOST, TOP
from ppaas.planners.hub_labels.kernels.scan import Integers, octile

NEXT, BEGIN, END = range(3)
"""State of a slot: its next node, and begin and end of its free space among the gates."""


@bare
def _offer(
    hub: int, length: int, edge: int, best: Integers, by_edge: Integers, candidates: Integers, count: int
) -> int:
    """Offer a path to a hub; return the new number of candidates."""
    if best[hub] == FAR:
        candidates[count] = hub
        count += 1
    if length < best[hub]:
        best[hub] = length
        by_edge[hub] = edge
    return count


@bare
def _gather_candidates(
    node: int, labelled: int, starts: Words, to: Integers, far: Integers,
    gates: Integers, lengths: Integers, begins: Words, ends: Words,
    best: Integers, by_edge: Integers, candidates: Integers,
) -> int:  # fmt: skip
    """Collect candidate gates from the edges of a node and the gates of the nodes above, sorted by distance."""
    count = np.int64(0)
    for edge in range(starts[node], starts[node + 1]):
        above, own = to[edge], edge - starts[node]
        if above < labelled:
            count = _offer(np.int64(above), np.int64(far[edge]), own, best, by_edge, candidates, count)
            continue
        for i in range(begins[above], ends[above]):
            hub = np.int64(gates[i] & ((1 << HUB_BITS) - 1))
            count = _offer(hub, np.int64(lengths[i]) + far[edge], own, best, by_edge, candidates, count)
    for i in range(1, count):
        hub, place = candidates[i], i
        while place > 0 and best[candidates[place - 1]] > best[hub]:
            candidates[place] = candidates[place - 1]
            place -= 1
        candidates[place] = hub
    return int(count)


@bare
def _is_gate(
    hub: int, by_edge: int, first: int, last: int, gates: Integers, lengths: Integers, positions: Rows,
    hubs: Integers, far: Integers, label_begins: Words, label_ends: Words, best: Integers, reach: Integers,
) -> bool:  # fmt: skip
    """Return whether no earlier gate is on a shortest path to a hub."""
    begin, end = label_begins[hub], label_ends[hub]
    is_scattered, is_gate = False, True
    for i in range(first, last):
        if gates[i] >> HUB_BITS == by_edge:
            continue  # both are gates of the corner at the end of that edge
        gate = gates[i] & ((1 << HUB_BITS) - 1)
        distance = octile(positions[hub, 0] - positions[gate, 0], positions[hub, 1] - positions[gate, 1])
        if lengths[i] + distance > best[hub]:
            continue
        if not is_scattered:
            is_scattered = True
            scatter(reach, hubs, far, begin, end)
        most = best[hub] - lengths[i]
        if length_up_to(reach, hubs, far, label_begins[gate], label_ends[gate], most) <= most:
            is_gate = False
            break
    if is_scattered:
        clear(reach, hubs, begin, end)
    return is_gate


@bare
def _beats_gates(
    node: int, length: int, gates: Integers, lengths: Integers, begins: Words, ends: Words, best: Integers
) -> bool:
    """Return whether a path to a node is shorter than through any of its gates."""
    for i in range(begins[node], ends[node]):
        if np.int64(best[gates[i] & ((1 << HUB_BITS) - 1)]) + lengths[i] <= length:
            return False
    return True


@bare
def _find_local(
    node: int, labelled: int, starts: Words, to: Integers, far: Integers,
    gates: Integers, lengths: Integers, begins: Words, ends: Words, best: Integers, local: Words,
) -> None:  # fmt: skip
    """Mark the local edges of a node."""
    for edge in range(starts[node], starts[node + 1]):
        if to[edge] >= labelled and _beats_gates(
            np.int64(to[edge]), np.int64(far[edge]), gates, lengths, begins, ends, best
        ):
            local[edge] = 1


@bare
def _holds(boxes: Rows, node: int, other: int) -> bool:
    """Return whether the rectangle of a node contains that of another one."""
    return bool(
        boxes[node, TOP] <= boxes[other, TOP] and boxes[node, LEFTMOST] <= boxes[other, LEFTMOST]
        and boxes[node, BOTTOM] >= boxes[other, BOTTOM] and boxes[node, RIGHTMOST] >= boxes[other, RIGHTMOST]
    )  # fmt: skip


@bare
def _set_box(
    node: int, starts: Words, to: Integers, far: Integers,
    gates: Integers, lengths: Integers, begins: Words, ends: Words, positions: Rows,
    best: Integers, local: Words, boxes: Rows, near: Integers, touched: Integers, heap: Words,
) -> None:  # fmt: skip
    """Compute the bounding rectangle of the corners that a node reaches over local edges faster than over any gate."""
    boxes[node, TOP] = boxes[node, BOTTOM] = positions[node, 0]
    boxes[node, LEFTMOST] = boxes[node, RIGHTMOST] = positions[node, 1]
    near[node] = 0
    touched[0] = node
    count, queued = 1, push(heap, 0, len(near) - node, node)
    while queued > 0:
        corner = heap[0] & NODE
        queued = pop(heap, queued)
        if corner != node:
            # Corners behind it are inside its own rectangle, which is already contained.
            if _holds(boxes, node, corner):
                continue
            if not _beats_gates(corner, np.int64(near[corner]), gates, lengths, begins, ends, best):
                continue
            boxes[node, TOP] = min(boxes[node, TOP], positions[corner, 0])
            boxes[node, BOTTOM] = max(boxes[node, BOTTOM], positions[corner, 0])
            boxes[node, LEFTMOST] = min(boxes[node, LEFTMOST], positions[corner, 1])
            boxes[node, RIGHTMOST] = max(boxes[node, RIGHTMOST], positions[corner, 1])
        for edge in range(starts[corner], starts[corner + 1]):
            above, length = np.int64(to[edge]), near[corner] + far[edge]
            if local[edge] and length < near[above]:
                if near[above] == FAR:
                    touched[count] = above
                    count += 1
                    queued = push(heap, queued, len(near) - above, above)
                near[above] = length
    for i in range(count):
        near[touched[i]] = FAR


@bare
def _find_slot(
    nodes: Integers, labelled: int, starts: Words, to: Integers, far: Integers, positions: Rows,
    hubs: Integers, label_lengths: Integers, label_begins: Words, label_ends: Words,
    gates: Integers, lengths: Integers, begins: Words, ends: Words, local: Words, boxes: Rows,
    best: Integers, by_edge: Integers, reach: Integers, candidates: Integers,
    near: Integers, touched: Integers, heap: Words, window: Words, slots: int, budget: int,
) -> None:  # fmt: skip
    work = 0
    while window[NEXT] < len(nodes) and work < budget:
        node = nodes[window[NEXT]]
        count = _gather_candidates(
            node, labelled, starts, to, far, gates, lengths, begins, ends, best, by_edge, candidates
        )
        if window[BEGIN] + count > window[END]:
            for i in range(count):
                best[candidates[i]] = FAR
            return
        # Keep candidates that no nearer gate covers.
        first = last = window[BEGIN]
        for i in range(count):
            hub = np.int64(candidates[i])
            if _is_gate(
                hub, np.int64(by_edge[hub]), first, last, gates, lengths, positions,
                hubs, label_lengths, label_begins, label_ends, best, reach,
            ):  # fmt: skip
                gates[last] = hub | (by_edge[hub] << HUB_BITS)
                lengths[last] = best[hub]
                last += 1
        begins[node], ends[node] = first, last
        _find_local(node, labelled, starts, to, far, gates, lengths, begins, ends, best, local)
        _set_box(
            np.int64(node), starts, to, far, gates, lengths, begins, ends, positions,
            best, local, boxes, near, touched, heap,
        )  # fmt: skip
        for i in range(count):
            best[candidates[i]] = FAR
        window[BEGIN] = last
        window[NEXT] += slots
        work += 256 + 8 * count


@bare
def _find_serial(
    nodes: Integers, labelled: int, starts: Words, to: Integers, far: Integers, positions: Rows,
    hubs: Integers, label_lengths: Integers, label_begins: Words, label_ends: Words,
    gates: Integers, lengths: Integers, begins: Words, ends: Words, local: Words, boxes: Rows,
    scratch: Rows, records: Rows, heaps: Heaps, windows: Heaps, budget: int,
) -> None:  # fmt: skip
    for slot in range(len(windows)):
        _find_slot(
            nodes, labelled, starts, to, far, positions, hubs, label_lengths, label_begins, label_ends,
            gates, lengths, begins, ends, local, boxes,
            scratch[4 * slot], scratch[4 * slot + 1], scratch[4 * slot + 2], scratch[4 * slot + 3],
            records[2 * slot], records[2 * slot + 1], heaps[slot], windows[slot], len(windows), budget,
        )  # fmt: skip


@compiled(parallel=True)
def _find_parallel(
    nodes: Integers, labelled: int, starts: Words, to: Integers, far: Integers, positions: Rows,
    hubs: Integers, label_lengths: Integers, label_begins: Words, label_ends: Words,
    gates: Integers, lengths: Integers, begins: Words, ends: Words, local: Words, boxes: Rows,
    scratch: Rows, records: Rows, heaps: Heaps, windows: Heaps, budget: int,
) -> None:  # fmt: skip
    for slot in prange(len(windows)):
        _find_slot(
            nodes, labelled, starts, to, far, positions, hubs, label_lengths, label_begins, label_ends,
            gates, lengths, begins, ends, local, boxes,
            scratch[4 * slot], scratch[4 * slot + 1], scratch[4 * slot + 2], scratch[4 * slot + 3],
            records[2 * slot], records[2 * slot + 1], heaps[slot], windows[slot], len(windows), budget,
        )  # fmt: skip


def find_gates(
    nodes: Integers, labelled: int, starts: Words, to: Integers, far: Integers, positions: Rows,
    hubs: Integers, label_lengths: Integers, label_begins: Words, label_ends: Words,
    gates: Integers, lengths: Integers, begins: Words, ends: Words, local: Words, boxes: Rows,
    scratch: Rows, records: Rows, heaps: Heaps, windows: Heaps, budget: int, threads: int,
) -> None:  # fmt: skip
    """Find the gates of the nodes of a level until the budget of each slot is used, its space is full, or all are done.

    Parameters
    ----------
    nodes : (k,) int32 array
        Nodes of the level, numbered by importance; slot s of S takes nodes s, s + S, s + 2 S …
    labelled : int
        Number of labelled nodes; they are the first.
    starts : (n + 1,) int64 array
        First edge of each node.
    to, far : int32 arrays
        End and length of each edge to a more important node.
    positions : (n, 2) int32 array
        Row and column of each node.
    hubs, label_lengths, label_begins, label_ends
        The pool of labels: hub and distance of each entry, and the range of each label.
    gates, lengths : (m,) int32 arrays
        Out: gates, encoded as `HUB_BITS` describes, and their distances.
    begins, ends : (n,) int64 arrays
        Out: range of the gates of each node.
    local : (edges,) int64 array
        Out: 1 for each local edge; zero at first.
    boxes : (n, 4) int32 array
        Out: bounding rectangle of the corners that each node reaches over local edges faster than over any gate; last
        row and column included.
    scratch : (4 S, ``labelled``) int32 array
        Four arrays per slot, `FAR` at first: distance and first edge of each candidate, distances of a scattered label,
        and the list of candidates.
    records : (2 S, n) int32 array
        Two arrays per slot, `FAR` at first: distances, and the list of reached nodes.
    heaps : (S, n) int64 array
        Scratch: heap of each slot.
    windows : (S, 3) int64 array
        State of each slot.
    budget : int
        Limit of the work of a slot in this call.
    threads : int
        Maximum number of threads.
    """
    with limit_threads(threads) as usable:
        kernel = _find_parallel if usable > 1 else _find_serial
        kernel(
            nodes, labelled, starts, to, far, positions, hubs, label_lengths, label_begins, label_ends,
            gates, lengths, begins, ends, local, boxes, scratch, records, heaps, windows, budget,
        )  # fmt: skip


def warm() -> None:
    """Compile and call each kernel once."""
    nothing = np.empty(0, np.int32)
    for threads in (1, 2):
        far, rows, windows = np.zeros(1, np.int64), np.zeros((4, 1), np.int32), np.zeros((1, 3), np.int64)
        find_gates(
            nothing, 0, far, nothing, nothing, rows, nothing, nothing, far, far,
            nothing, nothing, far, far, far, rows, rows, rows, windows, windows, 1, threads,
        )  # fmt: skip
