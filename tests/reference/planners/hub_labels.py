"""Slow, obvious twins of the hub-label kernels: corners, visibility, path lengths, coverage order and hubs."""

import heapq

import numpy as np
from numpy.typing import NDArray

Cell = tuple[int, int]


def is_free(free: NDArray[np.bool_], row: int, column: int) -> bool:
    """Return whether a cell is on the map and free."""
    return 0 <= row < free.shape[0] and 0 <= column < free.shape[1] and bool(free[row, column])


def corners(free: NDArray[np.bool_]) -> list[Cell]:
    """Return the free cells diagonal to a blocked one with the two cells between free, row by row."""
    return [
        (int(r), int(c))
        for r, c in zip(*np.nonzero(free), strict=True)
        if any(
            is_free(free, r + dr, c) and is_free(free, r, c + dc) and not is_free(free, r + dr, c + dc)
            for dr in (-1, 1)
            for dc in (-1, 1)
        )
    ]


def cells_between(a: Cell, b: Cell) -> set[Cell]:
    """Return all cells on the shortest paths from a to b on an empty map."""
    rows, columns = b[0] - a[0], b[1] - a[1]
    down, right = int(np.sign(rows)), int(np.sign(columns))
    diagonal, straight = min(abs(rows), abs(columns)), abs(abs(rows) - abs(columns))
    along = (down, 0) if abs(rows) > abs(columns) else (0, right)
    return {
        (a[0] + i * down + j * along[0], a[1] + i * right + j * along[1])
        for i in range(diagonal + 1)
        for j in range(straight + 1)
    }


def cuts_a_corner(free: NDArray[np.bool_], a: Cell, b: Cell) -> bool:
    """Return whether the path from a to b along the diagonal and then straight cuts a corner."""
    rows, columns = b[0] - a[0], b[1] - a[1]
    down, right = int(np.sign(rows)), int(np.sign(columns))
    return any(
        not (is_free(free, a[0] + (i + 1) * down, a[1] + i * right))
        or not is_free(free, a[0] + i * down, a[1] + (i + 1) * right)
        for i in range(min(abs(rows), abs(columns)))
    )


def octile(a: Cell, b: Cell) -> float:
    """Return the length of a path on an empty map [cells]."""
    rows, columns = abs(a[0] - b[0]), abs(a[1] - b[1])
    return max(rows, columns) + (2**0.5 - 1) * min(rows, columns)


def seen(free: NDArray[np.bool_], cell: Cell) -> set[Cell]:
    """Return the corners that a cell sees: all shortest paths on an empty map are free and pass no other corner."""
    every = corners(free)
    return {
        corner
        for corner in every
        if corner != cell
        and all(is_free(free, *between) for between in cells_between(cell, corner))
        and not (cells_between(cell, corner) & set(every)) - {cell, corner}
        and not cuts_a_corner(free, cell, corner)
    }


def lengths_from(free: NDArray[np.bool_], start: Cell) -> NDArray[np.float64]:
    """Return the distances of all cells from a free one [cells], by moves to eight neighbours that cut no corner."""
    lengths = np.full(free.shape, np.inf)
    lengths[start] = 0.0
    queue = [(0.0, start)]
    moves = [(dr, dc) for dr in (-1, 0, 1) for dc in (-1, 0, 1) if (dr, dc) != (0, 0)]
    while queue:
        length, (r, c) = heapq.heappop(queue)
        for dr, dc in moves:
            if not (is_free(free, r + dr, c) and is_free(free, r, c + dc) and is_free(free, r + dr, c + dc)):
                continue
            further = length + (dr * dr + dc * dc) ** 0.5
            if further < lengths[r + dr, c + dc] - 1e-9:
                lengths[r + dr, c + dc] = further
                heapq.heappush(queue, (further, (r + dr, c + dc)))
    return lengths


def length_of(free: NDArray[np.bool_], cells: NDArray[np.int32]) -> float:
    """Return the length of a path [cells]; infinite if it crosses a wall, cuts a corner, jumps or stops."""
    if (cells < 0).any() or (cells >= free.shape).any():
        return float("inf")
    (rows, columns), (next_rows, next_columns) = cells[:-1].T, cells[1:].T
    free_all = free[next_rows, next_columns] & free[rows, next_columns] & free[next_rows, columns]
    moves = np.abs(cells[1:] - cells[:-1])
    if not free_all.all() or (moves.max(axis=1, initial=0) != 1).any():
        return float("inf")
    return float(np.hypot(*moves.T).sum())


def most_covering(parents: list[list[int]], groups: int) -> list[int]:
    """Return the nodes that cover the most root paths of trees, until one covers fewer than there are trees.

    The best node comes first. ``parents`` has a row per tree: the parent of each node; −1 for the root and for nodes
    outside the tree. Paths through chosen nodes do not count, and neither do those of the group (tree i is in group i
    mod ``groups``) with the most.
    """
    nodes = range(len(parents[0]))
    roots = {(tree, row[node]) for tree, row in enumerate(parents) for node in nodes if row[node] >= 0}
    paths = []
    for tree, row in enumerate(parents):
        for node in nodes:
            path = [node]
            while row[path[-1]] >= 0:
                path.append(row[path[-1]])
            if len(path) > 1 or (tree, node) in roots:
                paths.append((tree % groups, set(path)))
    chosen: list[int] = []
    while len(chosen) < len(nodes):
        left = [(group, path) for group, path in paths if not path & set(chosen)]
        counts = [[0] * groups for _ in nodes]
        for group, path in left:
            for node in path:
                counts[node][group] += 1
        coverage = [
            -1 if node in chosen else sum(count) - max(count) for node, count in zip(nodes, counts, strict=True)
        ]
        best = coverage.index(max(coverage))
        if coverage[best] < len(parents):
            break
        chosen.append(best)
    return chosen


def hubs_of(nodes: int, lengths: dict[tuple[int, int], int]) -> list[dict[int, float]]:
    """Return the hubs of each node with their distances, given the lengths of edges; node 0 is the most important.

    A node is a hub of another if it is the most important of all nodes on shortest paths between both.
    """
    far = [[0 if a == b else float("inf") for b in range(nodes)] for a in range(nodes)]
    for (a, b), length in lengths.items():
        far[a][b] = far[b][a] = length
    for over in range(nodes):
        for a in range(nodes):
            for b in range(nodes):
                far[a][b] = min(far[a][b], far[a][over] + far[over][b])
    return [
        {
            hub: far[node][hub]
            for hub in range(nodes)
            if far[node][hub] < float("inf")
            and all(far[node][over] + far[over][hub] > far[node][hub] for over in range(hub))
        }
        for node in range(nodes)
    ]
