"""Slow, obvious twin of the distances: rounds over all cells until nothing changes."""

from ppaas.fleet.kernels.board import UNREACHABLE
from ppaas.fleet.roadmap import Roadmap


def distances(roadmap: Roadmap, goal: int) -> list[int]:
    """Return the number of moves from each cell to a goal."""
    found = {goal: 0}
    while True:
        more = {
            cell: 1 + min(found[int(near)] for near in moves if int(near) in found)
            for cell, moves in enumerate(roadmap.neighbours)
            if cell not in found and any(int(near) in found for near in moves)
        }
        if not more:
            return [found.get(cell, int(UNREACHABLE)) for cell in range(len(roadmap))]
        found |= more
