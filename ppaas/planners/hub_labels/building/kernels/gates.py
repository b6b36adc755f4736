"""Kernel: tell each corner of the fringe its gates, the labelled corners over which shortest ways leave the fringe.

Each corner of the fringe has edges to more important corners only. Those with labels that it reaches upwards are its
gates, but for those on the shortest way to which another gate lies. So on a shortest way between any two corners that
touches a corner with a label lies a gate of each of them (access nodes; Bast, Funke, Sanders and Schultes, "Fast
Routing in Road Networks with Transit Nodes", Science 2007).

Ways that touch no corner with a label are looked for by climbing. For that, an edge between two corners of the fringe
is *local* unless a gate of both lies on a way as short. Each corner has a rectangle that holds what it reaches over
local edges sooner than over any gate: two ends meet below all labels only where such rectangles do.
"""

import numpy as np
from numba import njit, prange

from ppaas.kernel_threads import at_most
from ppaas.planners.hub_labels.building.kernels.pool_distances import lay_out, take_back, told
from ppaas.planners.hub_labels.building.kernels.trees import Heaps, Rows
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.heap import NODE, pop, push
from ppaas.planners.hub_labels.kernels.layout import BOTTOM, FAR, HUB_BITS, LEFTMOST, RIGHTMOST, TOP
from ppaas.planners.hub_labels.kernels.scan import Integers, octile
from ppaas.planners.kernels.jit_decorators import bare

NEXT, BEGIN, END = range(3)


@bare
def _offer(hub: int, length: int, edge: int, best: Integers, came: Integers, offered: Integers, count: int) -> int:
    if best[hub] == FAR:
        offered[count] = hub
        count += 1
    if length < best[hub]:
        best[hub] = length
        came[hub] = edge
    return count


@bare
def _gather(
    node: int, labelled: int, starts: Words, to: Integers, far: Integers,
    gates: Integers, lengths: Integers, begins: Words, ends: Words, best: Integers, came: Integers, offered: Integers,
) -> int:  # fmt: skip
    count = np.int64(0)
    for edge in range(starts[node], starts[node + 1]):
        above, own = to[edge], edge - starts[node]
        if above < labelled:
            count = _offer(np.int64(above), np.int64(far[edge]), own, best, came, offered, count)
            continue
        for i in range(begins[above], ends[above]):
            hub = np.int64(gates[i] & ((1 << HUB_BITS) - 1))
            count = _offer(hub, np.int64(lengths[i]) + far[edge], own, best, came, offered, count)
    for i in range(1, count):
        hub, place = offered[i], i
        while place > 0 and best[offered[place - 1]] > best[hub]:
            offered[place] = offered[place - 1]
            place -= 1
        offered[place] = hub
    return int(count)


@bare
def _keep(
    hub: int, came: int, first: int, last: int, gates: Integers, lengths: Integers, places: Rows,
    hubs: Integers, far: Integers, label_begins: Words, label_ends: Words, best: Integers, reach: Integers,
) -> bool:  # fmt: skip
    """Tell whether no gate before lies on a shortest way to a hub."""
    begin, end = label_begins[hub], label_ends[hub]
    laid_out, kept = False, True
    for i in range(first, last):
        if gates[i] >> HUB_BITS == came:
            continue  # both are gates of the corner where that edge leads
        gate = gates[i] & ((1 << HUB_BITS) - 1)
        apart = octile(places[hub, 0] - places[gate, 0], places[hub, 1] - places[gate, 1])
        if lengths[i] + apart > best[hub]:
            continue
        if not laid_out:
            laid_out = True
            lay_out(reach, hubs, far, begin, end)
        most = best[hub] - lengths[i]
        if told(reach, hubs, far, label_begins[gate], label_ends[gate], most) <= most:
            kept = False
            break
    if laid_out:
        take_back(reach, hubs, begin, end)
    return kept


@bare
def _is_sooner(
    node: int, length: int, gates: Integers, lengths: Integers, begins: Words, ends: Words, best: Integers
) -> bool:
    """Tell whether a way to a node is shorter than over any of its gates."""
    for i in range(begins[node], ends[node]):
        if np.int64(best[gates[i] & ((1 << HUB_BITS) - 1)]) + lengths[i] <= length:
            return False
    return True


@bare
def _find_local(
    node: int, labelled: int, starts: Words, to: Integers, far: Integers,
    gates: Integers, lengths: Integers, begins: Words, ends: Words, best: Integers, local: Words,
) -> None:  # fmt: skip
    """Tell which edges of a node are local."""
    for edge in range(starts[node], starts[node + 1]):
        if to[edge] >= labelled and _is_sooner(
            np.int64(to[edge]), np.int64(far[edge]), gates, lengths, begins, ends, best
        ):
            local[edge] = 1


@bare
def _holds(boxes: Rows, node: int, other: int) -> bool:
    """Tell whether the rectangle of a node holds that of another one."""
    return bool(
        boxes[node, TOP] <= boxes[other, TOP] and boxes[node, LEFTMOST] <= boxes[other, LEFTMOST]
        and boxes[node, BOTTOM] >= boxes[other, BOTTOM] and boxes[node, RIGHTMOST] >= boxes[other, RIGHTMOST]
    )  # fmt: skip


@bare
def _enclose(
    node: int, starts: Words, to: Integers, far: Integers,
    gates: Integers, lengths: Integers, begins: Words, ends: Words, places: Rows,
    best: Integers, local: Words, boxes: Rows, near: Integers, touched: Integers, heap: Words,
) -> None:  # fmt: skip
    """Tell which rectangle holds what a node reaches over local edges sooner than over a gate."""
    boxes[node, TOP] = boxes[node, BOTTOM] = places[node, 0]
    boxes[node, LEFTMOST] = boxes[node, RIGHTMOST] = places[node, 1]
    near[node] = 0
    touched[0] = node
    count, queued = 1, push(heap, 0, len(near) - node, node)
    while queued > 0:
        corner = heap[0] & NODE
        queued = pop(heap, queued)
        if corner != node:
            # What lies behind it lies in its own rectangle, which holds no less than that.
            if _holds(boxes, node, corner):
                continue
            if not _is_sooner(corner, np.int64(near[corner]), gates, lengths, begins, ends, best):
                continue
            boxes[node, TOP] = min(boxes[node, TOP], places[corner, 0])
            boxes[node, BOTTOM] = max(boxes[node, BOTTOM], places[corner, 0])
            boxes[node, LEFTMOST] = min(boxes[node, LEFTMOST], places[corner, 1])
            boxes[node, RIGHTMOST] = max(boxes[node, RIGHTMOST], places[corner, 1])
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
def _open_slot(
    nodes: Integers, labelled: int, starts: Words, to: Integers, far: Integers, places: Rows,
    hubs: Integers, label_lengths: Integers, label_begins: Words, label_ends: Words,
    gates: Integers, lengths: Integers, begins: Words, ends: Words, local: Words, boxes: Rows,
    best: Integers, came: Integers, reach: Integers, offered: Integers,
    near: Integers, touched: Integers, heap: Words, window: Words, slots: int, budget: int,
) -> None:  # fmt: skip
    work = 0
    while window[NEXT] < len(nodes) and work < budget:
        node = nodes[window[NEXT]]
        count = _gather(node, labelled, starts, to, far, gates, lengths, begins, ends, best, came, offered)
        if window[BEGIN] + count > window[END]:
            for i in range(count):
                best[offered[i]] = FAR
            return
        first = last = window[BEGIN]
        for i in range(count):
            hub = np.int64(offered[i])
            if _keep(
                hub, np.int64(came[hub]), first, last, gates, lengths, places,
                hubs, label_lengths, label_begins, label_ends, best, reach,
            ):  # fmt: skip
                gates[last] = hub | (came[hub] << HUB_BITS)
                lengths[last] = best[hub]
                last += 1
        begins[node], ends[node] = first, last
        _find_local(node, labelled, starts, to, far, gates, lengths, begins, ends, best, local)
        _enclose(
            np.int64(node), starts, to, far, gates, lengths, begins, ends, places,
            best, local, boxes, near, touched, heap,
        )  # fmt: skip
        for i in range(count):
            best[offered[i]] = FAR
        window[BEGIN] = last
        window[NEXT] += slots
        work += 256 + 8 * count


@bare
def _open_serial(
    nodes: Integers, labelled: int, starts: Words, to: Integers, far: Integers, places: Rows,
    hubs: Integers, label_lengths: Integers, label_begins: Words, label_ends: Words,
    gates: Integers, lengths: Integers, begins: Words, ends: Words, local: Words, boxes: Rows,
    scratch: Rows, spots: Rows, heaps: Heaps, windows: Heaps, budget: int,
) -> None:  # fmt: skip
    for slot in range(len(windows)):
        _open_slot(
            nodes, labelled, starts, to, far, places, hubs, label_lengths, label_begins, label_ends,
            gates, lengths, begins, ends, local, boxes,
            scratch[4 * slot], scratch[4 * slot + 1], scratch[4 * slot + 2], scratch[4 * slot + 3],
            spots[2 * slot], spots[2 * slot + 1], heaps[slot], windows[slot], len(windows), budget,
        )  # fmt: skip


@njit(cache=True, nogil=True, error_model="numpy", parallel=True)
def _open_parallel(
    nodes: Integers, labelled: int, starts: Words, to: Integers, far: Integers, places: Rows,
    hubs: Integers, label_lengths: Integers, label_begins: Words, label_ends: Words,
    gates: Integers, lengths: Integers, begins: Words, ends: Words, local: Words, boxes: Rows,
    scratch: Rows, spots: Rows, heaps: Heaps, windows: Heaps, budget: int,
) -> None:  # fmt: skip
    for slot in prange(len(windows)):
        _open_slot(
            nodes, labelled, starts, to, far, places, hubs, label_lengths, label_begins, label_ends,
            gates, lengths, begins, ends, local, boxes,
            scratch[4 * slot], scratch[4 * slot + 1], scratch[4 * slot + 2], scratch[4 * slot + 3],
            spots[2 * slot], spots[2 * slot + 1], heaps[slot], windows[slot], len(windows), budget,
        )  # fmt: skip


def open_gates(
    nodes: Integers, labelled: int, starts: Words, to: Integers, far: Integers, places: Rows,
    hubs: Integers, label_lengths: Integers, label_begins: Words, label_ends: Words,
    gates: Integers, lengths: Integers, begins: Words, ends: Words, local: Words, boxes: Rows,
    scratch: Rows, spots: Rows, heaps: Heaps, windows: Heaps, budget: int, threads: int,
) -> None:  # fmt: skip
    """Find gates of nodes of one level until each slot has looked at so many, or its window is short, or all is done.

    Parameters
    ----------
    nodes : (k,) int32 array
        Numbered by importance; slot s of S takes the nodes s, s + S, s + 2 S …
    labelled : int
        How many nodes have labels; they are the first.
    starts, to, far
        The graph: edges to more important nodes.
    places : (n, 2) int32 array
        Row and column of each.
    hubs, label_lengths, label_begins, label_ends
        The labels.
    gates, lengths : (m,) int32 arrays
        Out: gates as `HUB_BITS` tells, and how far each is.
    begins, ends : (n,) int64 arrays
        Out: where the gates of each node lie.
    local : (edges,) int64 array
        Out: one for each local edge; zero at first.
    boxes : (n, 4) int32 array
        Out: the rectangle that holds all corners which are reached over local edges, and not as soon over a gate;
        last row and column included.
    scratch : (4 S, ``labelled``) int32 array
    spots : (2 S, n) int32 array
        Both `FAR` everywhere at first.
    heaps : (S, n) int64 array
        Scratch.
    windows : (S, 3) int64 array
        The slot's next node, the begin of its free room among the gates, and its end.
    budget, threads : int
    """
    with at_most(threads) as usable:
        kernel = _open_parallel if usable > 1 else _open_serial
        kernel(
            nodes, labelled, starts, to, far, places, hubs, label_lengths, label_begins, label_ends,
            gates, lengths, begins, ends, local, boxes, scratch, spots, heaps, windows, budget,
        )  # fmt: skip


def warm() -> None:
    """Compile and call each kernel once."""
    nothing = np.empty(0, np.int32)
    for threads in (1, 2):
        far, rows, windows = np.zeros(1, np.int64), np.zeros((4, 1), np.int32), np.zeros((1, 3), np.int64)
        open_gates(
            nothing, 0, far, nothing, nothing, rows, nothing, nothing, far, far,
            nothing, nothing, far, far, far, rows, rows, rows, windows, windows, 1, threads,
        )  # fmt: skip
