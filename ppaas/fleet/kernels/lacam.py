"""Kernel: search for a plan of all robots by lazy constraints addition (LaCAM).

A *configuration* is the cell of each robot. The search is depth-first in the graph of configurations; `pibt.decide`
proposes the next one. Each time that it comes back to a configuration, one more *constraint* "this robot goes into that
cell" is laid on the step, so that in the end all next configurations are tried. Source: Okumura, "LaCAM: Search-Based
Algorithm for Quick Multi-Agent Pathfinding", AAAI 2023.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.fleet.kernels.board import UNREACHABLE, Board, Ints, Step, is_barred, smallest_board, step_of
from ppaas.fleet.kernels.pibt import decide, is_possible
from ppaas.kernel_cache.decorators import compiled

Longs = NDArray[np.int64]

BRANCHES = 6
"""Largest number of constraints that one iteration adds."""

FOUND, EXHAUSTED, PAUSED, FULL = 1, 2, 3, 4
"""Results of `explore`: a plan was found, no plan exists, the budget is used up, or an array is full."""

PARENT, FIRST, LAST = 0, 1, 2
"""Columns of ``nodes``: parent, and first and last constraint that was not tried, −1 for none."""

ABOVE, ROBOT, CELL, DEPTH, NEXT = 0, 1, 2, 3, 4
"""Columns of ``constraints``: the one above, robot, cell, number of those above, and the next one of the same node."""

NODES, CONSTRAINTS, HEIGHT, CURRENT, IS_NEW, STATE = 0, 1, 2, 3, 4, 5
"""Elements of the state: numbers of nodes and constraints, height of the stack, current node, and whether ``step.to``
is a new node below it."""


class Search(NamedTuple):
    """Memory of a search.

    Parameters
    ----------
    cells : (m, n) int32 array
        Configuration of each node.
    ages : (m, n) float32 array
        Priority of each robot in each node: the number of steps for which it has been away from its goal.
    nodes : (m, 3) int32 array
        `PARENT`, `FIRST`, `LAST` of each node.
    constraints : (c, 5) int32 array
    stack : (s,) int32 array
        Nodes of the depth-first search.
    table : (t,) int32 array
        Hash table of the nodes by their cells; −1 is empty. t is a power of 2.
    salt : (n,) uint64 array
        Random odd number of each robot, for hashes.
    order : (n,) int64 array
        Robots by priority in the current node.
    required : (n,) bool array
        True for robots that must be at their goals at the end.
    state : (5,) int64 array
    """

    cells: Ints
    ages: NDArray[np.float32]
    nodes: Ints
    constraints: Ints
    stack: Ints
    table: Ints
    salt: NDArray[np.uint64]
    order: Longs
    required: NDArray[np.bool_]
    state: Longs


@compiled
def slot_of(search: Search, cells: Ints) -> int:
    """Return the place of a configuration in the hash table: where it is, or the empty one for it."""
    key = np.uint64(0)
    for robot in range(len(cells)):
        mixed = (np.uint64(cells[robot]) + np.uint64(1)) * search.salt[robot]
        key += mixed ^ (mixed >> np.uint64(29))
    last = np.uint64(len(search.table) - 1)
    slot = (key ^ (key >> np.uint64(32))) & last
    while search.table[slot] >= 0:
        if np.array_equal(search.cells[search.table[slot]], cells):
            break
        slot = (slot + np.uint64(1)) & last
    return int(slot)


@compiled
def fill_table(search: Search) -> None:
    """Enter all nodes into the hash table, which is empty."""
    for node in range(search.state[NODES]):
        search.table[slot_of(search, search.cells[node])] = node


@compiled
def is_full(search: Search) -> bool:
    """Return whether one more iteration may need more memory."""
    state = search.state
    return bool(
        state[NODES] == len(search.nodes)
        or 2 * state[NODES] >= len(search.table)
        or state[CONSTRAINTS] + BRANCHES > len(search.constraints)
        or state[HEIGHT] == len(search.stack)
    )


@compiled
def add_node(board: Board, step: Step, search: Search, slot: int) -> None:
    """Add the configuration ``step.to`` below the current node, and push it onto the stack."""
    state = search.state
    node, parent = state[NODES], state[CURRENT]
    search.cells[node] = step.to
    for robot in range(len(step.to)):
        if parent < 0:
            search.ages[node, robot] = board.distances[robot, step.to[robot]] / np.float32(UNREACHABLE)
        else:
            age = search.ages[parent, robot]
            away = board.goals[robot] != step.to[robot]
            search.ages[node, robot] = age + np.float32(1) if away else age - np.floor(age)
    search.table[slot] = node
    added = add_constraint(search, -1, -1, -1, 0)
    search.nodes[node, PARENT], search.nodes[node, FIRST], search.nodes[node, LAST] = parent, added, added
    search.stack[state[HEIGHT]] = node
    state[NODES], state[HEIGHT] = node + 1, state[HEIGHT] + 1


@compiled
def add_constraint(search: Search, above: int, robot: int, cell: int, depth: int) -> int:
    """Add a constraint, and return its number."""
    added = search.state[CONSTRAINTS]
    row = search.constraints[added]
    row[ABOVE], row[ROBOT], row[CELL], row[DEPTH], row[NEXT] = above, robot, cell, depth, -1
    search.state[CONSTRAINTS] = added + 1
    return int(added)


@compiled
def branch(board: Board, search: Search, node: int, above: int) -> None:
    """Append, to the constraints of a node, one for each cell of the next robot below the constraint ``above``."""
    depth = search.constraints[above, DEPTH]
    if depth >= len(search.order):
        return
    robot = search.order[depth]
    cell = search.cells[node, robot]
    for k in range(5):
        near = board.neighbours[cell, k] if k < 4 else cell
        if near < 0 or (k < 4 and is_barred(board, robot, near)):
            continue
        added = add_constraint(search, above, robot, near, depth + 1)
        if search.nodes[node, FIRST] < 0:
            search.nodes[node, FIRST] = added
        else:
            search.constraints[search.nodes[node, LAST], NEXT] = added
        search.nodes[node, LAST] = added


@compiled
def constrain(board: Board, step: Step, search: Search, constraint: int) -> bool:
    """Lay a constraint and all above it on a step; return False if they contradict each other."""
    step.to[:] = -1
    row = search.constraints[constraint]
    if row[ROBOT] < 0:
        return True
    while row[ROBOT] >= 0:
        step.to[row[ROBOT]] = row[CELL]
        row = search.constraints[row[ABOVE]]
    return bool(is_possible(board, step))


@compiled
def is_goal(board: Board, step: Step, search: Search) -> bool:
    """Return whether all required robots are at their goals."""
    for robot in range(len(step.at)):  # noqa: SIM110 - a kernel has no generators
        if search.required[robot] and step.at[robot] != board.goals[robot]:
            return False
    return True


@compiled
def explore(board: Board, step: Step, search: Search, budget: int) -> int:
    """Search on for up to ``budget`` steps of all robots.

    Parameters
    ----------
    board, step, search
        See there. ``step.to`` holds the starts, and ``search.state`` (0, 0, 0, −1, 1), before the first call.
    budget : int

    Returns
    -------
    int
        `FOUND`, with the last node in ``state[CURRENT]``; `EXHAUSTED`, `PAUSED` or `FULL`.
    """
    state = search.state
    for _ in range(budget):
        if is_full(search):
            return FULL
        if state[IS_NEW]:
            slot = slot_of(search, step.to)
            if search.table[slot] < 0:
                add_node(board, step, search, slot)
            else:
                search.stack[state[HEIGHT]] = search.table[slot]
                state[HEIGHT] += 1
            state[IS_NEW] = 0
        if state[HEIGHT] == 0:
            return EXHAUSTED
        node = search.stack[state[HEIGHT] - 1]
        if state[CURRENT] != node:
            state[CURRENT] = node
            step.at[:] = search.cells[node]
            search.order[:] = np.argsort(-search.ages[node])
            if is_goal(board, step, search):
                return FOUND
        constraint = search.nodes[node, FIRST]
        if constraint < 0:
            state[HEIGHT] -= 1
            continue
        search.nodes[node, FIRST] = search.constraints[constraint, NEXT]
        branch(board, search, node, constraint)
        if constrain(board, step, search, constraint) and decide(board, step, search.order):
            state[IS_NEW] = 1
    return PAUSED


def warm() -> None:
    """Compile and call each kernel once."""
    step = step_of(smallest_board(), np.zeros(1, np.int32), 0)
    step.to[:] = step.at
    search = Search(
        np.empty((4, 1), np.int32), np.empty((4, 1), np.float32), np.empty((4, 3), np.int32),
        np.empty((32, 5), np.int32), np.empty(8, np.int32), np.full(16, -1, np.int32), np.ones(1, np.uint64),
        np.zeros(1, np.int64), np.ones(1, np.bool_), np.array([0, 0, 0, -1, 1]),
    )  # fmt: skip
    explore(smallest_board(), step, search, 4)
    search.table[:] = -1
    fill_table(search)
