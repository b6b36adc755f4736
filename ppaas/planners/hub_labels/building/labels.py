"""Labels of all corners, in the order of their importance."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ppaas.planners.hub_labels.building.core_labels import CoreLabels
from ppaas.planners.hub_labels.building.graph import WORK_A_SLICE, ContractedGraph
from ppaas.planners.hub_labels.building.importance import RankedEdges, edges_of, order_core
from ppaas.planners.hub_labels.building.kernels.label_merging import merge
from ppaas.planners.hub_labels.building.label_pool import FEW, LabelPool, too_long
from ppaas.planners.hub_labels.kernels import layout
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.layout import FAR
from ppaas.planners.hub_labels.kernels.scan import Integers

WINDOW = 1 << 16
"""Minimum number of entries that a slot gets space for at once."""


@dataclass(frozen=True, slots=True)
class _Ranked:
    nodes: Integers
    ranks: Integers
    core: int


def label(
    contracted: ContractedGraph, inherited: Integers | None, *, most_entries: int, longest: int, threads: int,
    check: Callable[[], None],
) -> LabelPool | None:  # fmt: skip
    """Order the nodes of a contracted graph by importance and label them; return None if the core does not fit.

    Core nodes are ordered by inherited ranks, if given. The most important nodes are labelled, as many as
    ``most_entries`` allows.

    Raises
    ------
    InvalidPlanner
        A path between two corners is longer than ``longest``.
    """
    ranked = _rank(contracted, inherited, threads=threads, check=check)
    edges = edges_of(contracted, ranked.nodes, ranked.ranks)
    pool = LabelPool(ranked.ranks)
    if not CoreLabels(pool, edges, ranked.core, longest=longest, threads=threads).label(most_entries, check):
        return None
    levels = contracted.levels[ranked.nodes]
    _label_rest(
        pool, edges, levels, ranked.core, most_entries=most_entries, longest=longest, threads=threads, check=check
    )
    return pool


def _rank(
    contracted: ContractedGraph, inherited: Integers | None, *, threads: int, check: Callable[[], None]
) -> _Ranked:
    ranks = np.full(len(contracted.head), -1, np.int32)
    # By level: labels depend only on labels of higher levels.
    last = contracted.order[::-1]
    last = last[np.argsort(-contracted.levels[last], kind="stable")]
    ranks[last] = np.arange(len(ranks) - len(last), len(ranks))
    core = np.flatnonzero(ranks < 0).astype(np.int32)
    ranks[core] = np.arange(len(core))
    if inherited is None:
        order = order_core(edges_of(contracted, core, ranks), threads=threads, check=check)
    else:
        # As unsigned numbers, missing ranks (−1) come last.
        order = np.argsort(inherited[core].view(np.uint32), kind="stable").astype(np.int32)
    nodes = np.concatenate((core[order], last))
    ranks[nodes] = np.arange(len(nodes))
    return _Ranked(nodes, ranks, len(core))


def _label_rest(
    pool: LabelPool, edges: RankedEdges, levels: Integers, core: int, *, most_entries: int, longest: int, threads: int,
    check: Callable[[], None],
) -> None:  # fmt: skip
    nodes, slots = len(pool.ranks), max(1, threads)
    reach, by_edge = np.full((2, slots, nodes), FAR, np.int32)
    marks = np.zeros((slots, (nodes + 63) // 64), np.int64)
    others = np.arange(core, nodes, dtype=np.int32)
    windows = np.zeros((slots, 4), np.int64)
    for whole in np.split(others, np.flatnonzero(np.diff(levels[others])) + 1):
        level = whole[: _most_labels(pool, most_entries)]
        if not len(level):
            break
        usable = threads if len(level) >= FEW else 1
        windows[:, 0] = np.arange(slots)
        while (windows[:, 0] < len(level)).any():
            check()
            before = windows[:, 0].copy()
            merge(
                level, edges.starts, edges.to, edges.lengths, edges.ids,
                pool.hubs, pool.lengths, pool.towards, pool.begins, pool.ends,
                reach, by_edge, marks, windows, longest, WORK_A_SLICE, usable,
            )  # fmt: skip
            if windows[:, 3].any():
                raise too_long(longest)
            for slot in np.flatnonzero((windows[:, 0] == before) & (before < len(level))):
                _open_window(pool, windows[slot], _most_entries(pool, edges, int(level[windows[slot, 0]])), check)
        pool.labelled += len(level)


def _most_labels(pool: LabelPool, most_entries: int) -> int:
    """Return the number of labels that still fit, assuming the mean size of those before."""
    labelled = pool.labelled
    if labelled == len(pool.ranks):
        return 0
    used = int((pool.ends[:labelled] - pool.begins[:labelled]).sum())
    mean = max(1, used // max(1, labelled))
    return max(0, min(layout.MOST_HUBS - labelled, (most_entries - used) // mean))


def _most_entries(pool: LabelPool, edges: RankedEdges, node: int) -> int:
    above = edges.to[edges.starts[node] : edges.starts[node + 1]]
    return int((pool.ends[above] - pool.begins[above]).sum()) + 1


def _open_window(pool: LabelPool, window: Words, least: int, check: Callable[[], None]) -> None:
    size = max(WINDOW, 2 * least, pool.used // 8)
    if pool.used + size > pool.capacity:
        pool.extend(max(size, pool.capacity // 2), check)
    window[1:3] = pool.used, pool.used + size
    pool.used += size
