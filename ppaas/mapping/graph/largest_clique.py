"""Largest clique of a graph: the largest set of nodes of which every two are connected."""

import numpy as np
from numpy.typing import NDArray

_EXPANSIONS = 20_000
"""Nodes of the search tree to expand before the largest clique found so far is returned."""

_Frame = tuple[list[int], int, list[tuple[int, int]]]


def largest_clique(connected: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return the nodes of a largest clique, ascending.

    Branch and bound with greedy colouring (Tomita, Seki, 2003; bit sets as in San Segundo et al., 2011). The search is
    exact up to a number of expansions, and greedy beyond it.

    Parameters
    ----------
    connected : (m, m) bool array
        Symmetric; the diagonal is ignored.
    """
    order = np.argsort(-connected.sum(axis=1), kind="stable")
    matrix = connected[np.ix_(order, order)] & ~np.eye(len(order), dtype=np.bool_)
    found = _CliqueSearch([_bits(row) for row in matrix]).run()
    return np.sort(order[found])


def _bits(mask: NDArray[np.bool_]) -> int:
    """Return a mask as an integer with bit k for entry k."""
    return int.from_bytes(np.packbits(mask, bitorder="little").tobytes(), "little")


class _CliqueSearch:
    """Depth-first search with the neighbours of each node as bit sets."""

    def __init__(self, neighbours: list[int]) -> None:
        self._neighbours = neighbours
        self._best: list[int] = []
        self._left = _EXPANSIONS

    def run(self) -> list[int]:
        """Return a largest clique."""
        # Frames of the depth-first search: clique, candidates, and the order in which to try them.
        everything = (1 << len(self._neighbours)) - 1
        stack: list[_Frame] = [([], everything, self._coloured(everything))] if everything else []
        while stack and self._left > 0:
            clique, candidates, order = stack[-1]
            if not order or len(clique) + order[-1][1] <= len(self._best):
                stack.pop()
                continue
            node, _ = order.pop()
            self._left -= 1
            stack[-1] = (clique, candidates & ~(1 << node), order)
            larger, remaining = [*clique, node], candidates & self._neighbours[node]
            if len(larger) > len(self._best):
                self._best = larger
            if remaining:
                stack.append((larger, remaining, self._coloured(remaining)))
        return self._best

    def _coloured(self, candidates: int) -> list[tuple[int, int]]:
        """Return candidates with their colours, ascending; a clique among the first of them has at most that many."""
        coloured, colour = [], 0
        while candidates:
            colour += 1
            free = candidates
            while free:
                node = (free & -free).bit_length() - 1
                coloured.append((node, colour))
                candidates &= ~(1 << node)
                free &= ~(1 << node) & ~self._neighbours[node]
        return coloured
