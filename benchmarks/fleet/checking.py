"""Check of plans, independent of the kernels that make them."""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from ppaas.fleet.plan import FleetPlan
from ppaas.fleet.roadmap import Roadmap


def faults_of(roadmap: Roadmap, plan: FleetPlan, starts: Sequence[int], goals: Sequence[int]) -> list[str]:
    """Return all that is wrong with a plan, one line each; an empty list for a valid one.

    Each robot must go from its start to its goal, in each step into a neighbouring cell or not at all. No two robots
    may be in one cell or exchange their cells, and no ring of robots may turn: each waits until the next cell is empty.
    An area must have room for robots that enter it, together with those that were in it before.
    """
    return [*_wrong_ends(plan, starts, goals), *_wrong_moves(roadmap, plan), *_conflicts(plan), *_full(roadmap, plan)]


def _wrong_ends(plan: FleetPlan, starts: Sequence[int], goals: Sequence[int]) -> Iterator[str]:
    if plan.steps.ndim != 2 or len(plan.steps) == 0 or plan.steps.shape[1] != len(starts):
        yield f"the plan has the shape {plan.steps.shape}, and there are {len(starts)} robots"
        return
    for row, wanted, name in ((plan.steps[0], starts, "start"), (plan.steps[-1], goals, "goal")):
        for robot in np.nonzero(row != np.asarray(wanted))[0]:
            yield f"robot {robot} is not at its {name}"


def _wrong_moves(roadmap: Roadmap, plan: FleetPlan) -> Iterator[str]:
    if plan.steps.size and not (plan.steps.min() >= 0 and plan.steps.max() < len(roadmap)):
        yield "a cell is not on the roadmap"
        return
    before, after = plan.steps[:-1], plan.steps[1:]
    allowed = (before == after) | (roadmap.neighbours[before] == after[..., np.newaxis]).any(axis=2)
    for time, robot in np.argwhere(~allowed):
        yield f"robot {robot} jumps at time {time}"


def _conflicts(plan: FleetPlan) -> Iterator[str]:
    for time, row in enumerate(plan.steps):
        cells, counts = np.unique(row, return_counts=True)
        for cell in cells[counts > 1]:
            yield f"robots {np.nonzero(row == cell)[0].tolist()} are in cell {cell} at time {time}"
    for time, (before, after) in enumerate(zip(plan.steps[:-1], plan.steps[1:], strict=True)):
        yield from _rings(time, before, after)


def _full(roadmap: Roadmap, plan: FleetPlan) -> Iterator[str]:
    for area, room in enumerate(roadmap.room.tolist()):
        inside = (roadmap.areas >> np.uint64(area) & np.uint64(1)).astype(np.bool_)[plan.steps]
        entering = (inside[1:] & ~inside[:-1]).sum(axis=1)
        for time in np.nonzero((entering > 0) & (inside[:-1].sum(axis=1) + entering > room))[0]:
            yield f"area {area} has no room for those who enter it at time {time}"


def _rings(time: int, before: NDArray[np.int32], after: NDArray[np.int32]) -> Iterator[str]:
    """Yield exchanges and rings: robots that move from cell to cell in a closed chain."""
    follows = {int(here): int(there) for here, there in zip(before, after, strict=True) if here != there}
    done: set[int] = set()
    for first in follows:
        chain: list[int] = []
        cell = first
        while cell in follows and cell not in done:
            done.add(cell)
            chain.append(cell)
            cell = follows[cell]
        if cell in chain:
            yield f"robots exchange the cells {chain[chain.index(cell) :]} at time {time}"
