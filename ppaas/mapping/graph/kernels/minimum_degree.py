"""Kernel: approximate minimum degree ordering of a symmetric sparse matrix, with the structure of its factor."""

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled

Ints = NDArray[np.int64]
Elimination = tuple[Ints, Ints, Ints]

_VARIABLE, _ELEMENT, _ABSORBED = 0, 1, 2


@compiled
def minimum_degree(starts: Ints, neighbours: Ints) -> Elimination:
    """Return an order of elimination with little fill, and the fill.

    Amestoy, Davis, Duff, *An approximate minimum degree ordering algorithm*, SIAM J. Matrix Anal. Appl. 17(4), 1996:
    the quotient graph, the approximate degree of section 4 and aggressive absorption, without supervariables.

    Parameters
    ----------
    starts : (n + 1,) array
        Start of each node's neighbours.
    neighbours : (2 m,) array
        Neighbours of node 0, of node 1, …; each edge is there in both directions, once.

    Returns
    -------
    order : (n,) array
        Node eliminated in each step.
    member_starts : (n + 1,) array
        Start of each step's members.
    members : (f,) array
        Nodes below the diagonal in the column of the factor that each step makes, in no order.
    """
    n = starts.size - 1
    # Quotient graph. List of node i: links[starts[i]:], first elements[i] elements, then variables[i] nodes. It never
    # grows: an elimination that adds an element to it removes the eliminated node, or an absorbed element.
    links = neighbours.copy()
    elements, variables = np.zeros(n, np.int64), starts[1:] - starts[:-1]
    state = np.full(n, _VARIABLE, np.int8)
    # Members of the element that node p became: members[first_member[p]:first_member[p] + size[p]].
    members = np.empty(max(16, 4 * neighbours.size), np.int64)
    first_member, size = np.zeros(n, np.int64), np.zeros(n, np.int64)
    order, member_starts = np.empty(n, np.int64), np.zeros(n + 1, np.int64)
    # Nodes by approximate degree, in doubly linked lists.
    degree = variables.copy()
    head, after, before = np.full(n + 1, -1, np.int64), np.full(n, -1, np.int64), np.full(n, -1, np.int64)
    for i in range(n):
        _link(i, degree[i], head, after, before)
    marked = np.full(n, -1, np.int64)  # step in which a node was last found to be a member
    outside, measured = np.zeros(n, np.int64), np.full(n, -1, np.int64)  # |Le \ Lp| of an element, and its step
    buffer = np.empty(n + 1, np.int64)
    least, used = 0, 0
    for step in range(n):
        # Pivot: a node of least degree.
        while head[least] < 0:
            least += 1
        p = head[least]
        _unlink(p, degree[p], head, after, before)
        # Members of the new element: neighbours of the pivot, and members of its elements, which it absorbs.
        begin, own = used, links[starts[p] : starts[p] + elements[p] + variables[p]]
        members = _with_space(members, used, own, state, size)
        marked[p] = step
        used = _gather_members(own, step, state, first_member, size, marked, members, used)
        state[p], first_member[p], size[p] = _ELEMENT, begin, used - begin
        order[step], member_starts[step + 1] = p, used
        # Parts of the other elements that are outside the new one.
        for q in range(begin, used):
            i = members[q]
            for e in links[starts[i] : starts[i] + elements[i]]:
                if state[e] == _ELEMENT:
                    if measured[e] != step:
                        measured[e], outside[e] = step, size[e]
                    outside[e] -= 1
        # Lists and degrees of the members.
        for q in range(begin, used):
            i = members[q]
            own = links[starts[i] : starts[i] + elements[i] + variables[i]]
            kept, count, beyond = _kept_links(own, elements[i], p, step, state, marked, outside, buffer)
            own[:count] = buffer[:count]
            elements[i], variables[i] = kept, count - kept
            _unlink(i, degree[i], head, after, before)
            others = used - begin - 1
            degree[i] = min(n - step - 2, degree[i] + others, variables[i] + others + beyond)
            _link(i, degree[i], head, after, before)
            least = min(least, degree[i])
    return order, member_starts, members[:used].copy()


@compiled
def _with_space(members: Ints, used: int, links: Ints, state: NDArray[np.int8], size: Ints) -> Ints:
    """Return the members, copied to a larger array if those of a new element may not fit."""
    needed = links.size
    for link in links:
        needed += size[link] if state[link] == _ELEMENT else 0
    if used + needed <= members.size:
        return members
    larger = np.empty(2 * members.size + needed, np.int64)
    larger[:used] = members[:used]
    return larger


@compiled
def _gather_members(
    links: Ints,
    step: int,
    state: NDArray[np.int8],
    first_member: Ints,
    size: Ints,
    marked: Ints,
    members: Ints,
    used: int,
) -> int:
    """Append the members of a new element, absorb the elements in the pivot's list, and return the new end."""
    for link in links:
        if state[link] == _VARIABLE and marked[link] != step:
            marked[link] = step
            members[used] = link
            used += 1
        elif state[link] == _ELEMENT:
            state[link] = _ABSORBED
            for q in range(first_member[link], first_member[link] + size[link]):
                node = members[q]
                if marked[node] != step:
                    marked[node] = step
                    members[used] = node
                    used += 1
    return used


@compiled
def _kept_links(
    links: Ints,
    elements: int,
    pivot: int,
    step: int,
    state: NDArray[np.int8],
    marked: Ints,
    outside: Ints,
    buffer: Ints,
) -> tuple[int, int, int]:
    """Write a member's new list into a buffer: the new element, live elements, and nodes that are not members.

    Elements without members outside the new one are absorbed. Returns the number of elements, the length of the list,
    and the sum of the elements' members outside the new one.
    """
    buffer[0] = pivot
    kept, beyond = 1, 0
    for e in links[:elements]:
        if state[e] == _ELEMENT and outside[e] > 0:
            buffer[kept] = e
            kept += 1
            beyond += outside[e]
        elif state[e] == _ELEMENT:
            state[e] = _ABSORBED
    count = kept
    for node in links[elements:]:
        if state[node] == _VARIABLE and marked[node] != step:
            buffer[count] = node
            count += 1
    return kept, count, beyond


@compiled
def _link(node: int, degree: int, head: Ints, after: Ints, before: Ints) -> None:
    """Put a node at the head of the list of its degree."""
    after[node], before[node] = head[degree], -1
    if head[degree] >= 0:
        before[head[degree]] = node
    head[degree] = node


@compiled
def _unlink(node: int, degree: int, head: Ints, after: Ints, before: Ints) -> None:
    """Remove a node from the list of its degree."""
    if before[node] >= 0:
        after[before[node]] = after[node]
    else:
        head[degree] = after[node]
    if after[node] >= 0:
        before[after[node]] = before[node]


def warm() -> None:
    """Call the kernel once, so that it is compiled or loaded from the cache."""
    minimum_degree(np.array((0, 1, 2)), np.array((1, 0)))
