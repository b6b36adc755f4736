"""Kernel: approximate minimum degree ordering of a symmetric sparse matrix, with the structure of its factor."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Elimination = tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]

_VARIABLE, _ELEMENT, _ABSORBED = 0, 1, 2


@njit(cache=True, nogil=True, error_model="numpy")
def minimum_degree(starts: NDArray[np.int64], neighbours: NDArray[np.int64]) -> Elimination:
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
        needed = variables[p]
        for k in range(starts[p], starts[p] + elements[p]):
            needed += size[links[k]] if state[links[k]] == _ELEMENT else 0
        if used + needed > members.size:
            larger = np.empty(2 * members.size + needed, np.int64)
            larger[:used] = members[:used]
            members = larger
        begin = used
        marked[p] = step
        for k in range(starts[p], starts[p] + elements[p] + variables[p]):
            link = links[k]
            if state[link] == _VARIABLE:
                if marked[link] != step:
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
        state[p], first_member[p], size[p] = _ELEMENT, begin, used - begin
        order[step], member_starts[step + 1] = p, used
        # Parts of the other elements that are outside the new one.
        for q in range(begin, used):
            i = members[q]
            for k in range(starts[i], starts[i] + elements[i]):
                e = links[k]
                if state[e] == _ELEMENT:
                    if measured[e] != step:
                        measured[e], outside[e] = step, size[e]
                    outside[e] -= 1
        # Lists and degrees of the members.
        for q in range(begin, used):
            i = members[q]
            begun, kept = starts[i], 1
            buffer[0] = p
            beyond = 0
            for k in range(begun, begun + elements[i]):
                e = links[k]
                if state[e] == _ELEMENT and outside[e] > 0:
                    buffer[kept] = e
                    kept += 1
                    beyond += outside[e]
                elif state[e] == _ELEMENT:
                    state[e] = _ABSORBED
            count = kept
            for k in range(begun + elements[i], begun + elements[i] + variables[i]):
                if marked[links[k]] != step and state[links[k]] == _VARIABLE:
                    buffer[count] = links[k]
                    count += 1
            links[begun : begun + count] = buffer[:count]
            elements[i], variables[i] = kept, count - kept
            _unlink(i, degree[i], head, after, before)
            others = used - begin - 1
            degree[i] = min(n - step - 2, degree[i] + others, variables[i] + others + beyond)
            _link(i, degree[i], head, after, before)
            least = min(least, degree[i])
    return order, member_starts, members[:used].copy()


@njit(cache=True, nogil=True, error_model="numpy")
def _link(node: int, degree: int, head: NDArray[np.int64], after: NDArray[np.int64], before: NDArray[np.int64]) -> None:
    """Put a node at the head of the list of its degree."""
    after[node], before[node] = head[degree], -1
    if head[degree] >= 0:
        before[head[degree]] = node
    head[degree] = node


@njit(cache=True, nogil=True, error_model="numpy")
def _unlink(
    node: int, degree: int, head: NDArray[np.int64], after: NDArray[np.int64], before: NDArray[np.int64]
) -> None:
    """Remove a node from the list of its degree."""
    if before[node] >= 0:
        after[before[node]] = after[node]
    else:
        head[degree] = after[node]
    if after[node] >= 0:
        before[after[node]] = before[node]
