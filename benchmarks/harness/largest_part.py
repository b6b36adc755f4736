"""Largest part of a hall, from whose cells starts and goals of robots are drawn."""

from ppaas.fleet.roadmap import Roadmap


def largest_part(roadmap: Roadmap) -> list[int]:
    """Return the cells of the largest part of a roadmap whose cells are connected, in ascending order."""
    left, best = set(range(len(roadmap))), set[int]()
    while left:
        part, new = set[int](), {left.pop()}
        while new:
            part.update(new)
            new = {int(n) for cell in new for n in roadmap.neighbours[cell] if n in left}
            left.difference_update(new)
        best = max(best, part, key=len)
    return sorted(best)
