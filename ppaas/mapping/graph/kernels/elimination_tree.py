"""Kernels: elimination tree of a factor, its postorder, and its supernodes (columns of one structure)."""

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled


@compiled
def elimination_tree(
    order: NDArray[np.int64], member_starts: NDArray[np.int64], members: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Return the parent (n,) of each step of an elimination: the step that eliminates the first of its members.

    −1 for a root. The arguments are those that ``minimum_degree`` returns.
    """
    n = order.size
    step_of = np.empty(n, np.int64)
    step_of[order] = np.arange(n)
    parents = np.full(n, -1, np.int64)
    for step in range(n):
        for q in range(member_starts[step], member_starts[step + 1]):
            other = step_of[members[q]]
            if parents[step] < 0 or other < parents[step]:
                parents[step] = other
    return parents


@compiled
def postorder(parents: NDArray[np.int64], counts: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the steps of an elimination in postorder of their tree, the child with the longest column last.

    That child is then next to its parent, and the two can become one supernode.

    Parameters
    ----------
    parents : (n,) array
        Parent of each step, −1 for a root; a parent comes after its children.
    counts : (n,) array
        Entries in the column of each step.
    """
    n = parents.size
    # Children of each step as linked lists; the longest is moved to the end.
    child, sibling, longest = np.full(n, -1, np.int64), np.full(n, -1, np.int64), np.full(n, -1, np.int64)
    for step in range(n):
        parent = parents[step]
        if parent >= 0 and (longest[parent] < 0 or counts[step] > counts[longest[parent]]):
            longest[parent] = step
    for step in range(n):
        parent = parents[step]
        if parent >= 0 and longest[parent] == step:
            child[parent] = step
    for step in range(n - 1, -1, -1):
        parent = parents[step]
        if parent >= 0 and longest[parent] != step:
            sibling[step] = child[parent]
            child[parent] = step
    visited, stack, done, depth = np.empty(n, np.int64), np.empty(n, np.int64), 0, 0
    for root in range(n):
        if parents[root] >= 0:
            continue
        stack[0], depth = root, 1
        while depth:
            step = stack[depth - 1]
            if child[step] >= 0:
                stack[depth] = child[step]
                child[step] = sibling[child[step]]
                depth += 1
            else:
                visited[done] = step
                done += 1
                depth -= 1
    return visited


@compiled
def supernodes(
    parents: NDArray[np.int64], counts: NDArray[np.int64], small: int, share: float
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the supernodes: runs of columns that are factorised together as one dense front.

    Neighbouring columns share a front if one is the parent of the other and has its structure without the diagonal.
    Relaxed: a front joins that of its parent, too, if few zeros are stored for it (Ashcraft, Grimes, *The influence of
    relaxed supernode partitions on the multifrontal method*, ACM TOMS 15(4), 1989).

    Parameters
    ----------
    parents, counts : (n,) array
        Parent and number of entries (with the diagonal) of each column, in postorder.
    small : int
        Fronts of at most these many columns are joined in any case.
    share : float
        Largest share of stored zeros in the columns of a joined front.

    Returns
    -------
    starts : (s + 1,) array
        First column of each supernode.
    heights : (s,) array
        Rows of its front.
    """
    n = parents.size
    starts, heights, zeros, count = np.empty(n + 1, np.int64), np.empty(n, np.int64), np.zeros(n, np.int64), 0
    for column in range(n):
        starts[count], heights[count], zeros[count] = column, counts[column], 0
        count += 1
        while count > 1:
            first, last = starts[count - 2], starts[count - 1] - 1
            if parents[last] < starts[count - 1] or parents[last] > column:
                break
            width, height = starts[count - 1] - first, column + 1 - starts[count - 1]
            joined = width + heights[count - 1]
            added = zeros[count - 2] + zeros[count - 1] + width * (joined - heights[count - 2])
            stored = (width + height) * joined
            if width + height > small and added > share * stored:
                break
            count -= 1
            heights[count - 1], zeros[count - 1] = joined, added
    starts[count] = n
    return starts[: count + 1].copy(), heights[:count].copy()


@compiled
def front_rows(
    starts: NDArray[np.int64],
    heights: NDArray[np.int64],
    column_steps: NDArray[np.int64],
    labels: NDArray[np.int64],
    member_starts: NDArray[np.int64],
    members: NDArray[np.int64],
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Return the rows of the fronts: their columns, and the structure of the last column, ascending.

    Parameters
    ----------
    starts, heights : (s + 1,), (s,) array
        First column of each supernode, and rows of its front.
    column_steps : (n,) array
        Step of the elimination that makes each column.
    labels : (n,) array
        Column of each node.
    member_starts, members : array
        Structure of each step, as ``minimum_degree`` returns it.

    Returns
    -------
    row_starts : (s + 1,) array
        Start of each front's rows.
    rows : (r,) array
        Rows of the fronts.
    children : (s,) array
        Number of fronts whose parent is each front.
    """
    count = heights.size
    row_starts = np.zeros(count + 1, np.int64)
    row_starts[1:] = np.cumsum(heights)
    rows, children = np.empty(row_starts[count], np.int64), np.zeros(count, np.int64)
    owner = np.empty(labels.size, np.int64)
    for s in range(count):
        owner[starts[s] : starts[s + 1]] = s
    for s in range(count):
        at = row_starts[s]
        for column in range(starts[s], starts[s + 1]):
            rows[at] = column
            at += 1
        step, below = column_steps[starts[s + 1] - 1], at
        for q in range(member_starts[step], member_starts[step + 1]):
            rows[at] = labels[members[q]]
            at += 1
        rows[below:at].sort()
        if at > below:
            children[owner[rows[below]]] += 1
    return row_starts, rows, children


def warm() -> None:
    """Call the kernels once, so that they are compiled or loaded from the cache."""
    order, member_starts, members = np.array((0, 1)), np.array((0, 1, 1)), np.array((1,))
    parents, counts = elimination_tree(order, member_starts, members), np.array((2, 1))
    steps = postorder(parents, counts)
    front_rows(*supernodes(parents, counts, 4, 0.25), steps, order, member_starts, members)
