"""Slow, obvious twin of the distances: rounds over all cells until nothing changes."""

from ppaas.fleet.kernels.board import UNREACHABLE
from ppaas.fleet.roadmap import Roadmap


def distances(roadmap: Roadmap, goal: int) -> list[int]:
    """Return the number of moves from each cell to a goal."""
    found = {goal: 0}
    while True:
        more = {
            int(near): found[cell] + 1
            for cell in found
            for near in roadmap.neighbours[cell]
            if near >= 0 and near not in found
        }
        if not more:
            return [found.get(cell, int(UNREACHABLE)) for cell in range(len(roadmap))]
        found |= more
