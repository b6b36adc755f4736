"""Slow, obvious twin of LaCAM: breadth-first search over the cells of all robots together."""

import itertools
from collections.abc import Iterator, Sequence

from ppaas.fleet.roadmap import Roadmap

Cells = tuple[int, ...]


def shortest(roadmap: Roadmap, starts: Sequence[int], goals: Sequence[int], sizes: Sequence[int] = ()) -> int | None:
    """Return the least number of steps after which all robots are at their goals; None if they never are.

    Robots of some sizes do not enter the cells that are barred for them.
    """
    wanted, first = tuple(map(int, goals)), tuple(map(int, starts))
    known, layer, steps = {first}, [first], 0
    while layer:
        if wanted in known:
            return steps
        layer = [after for before in layer for after in _next(roadmap, before, sizes) if after not in known]
        known |= set(layer)
        steps += 1
    return None


def _next(roadmap: Roadmap, before: Cells, sizes: Sequence[int]) -> Iterator[Cells]:
    ways = [[cell, *(int(near) for near in roadmap.neighbours[cell] if near >= 0)] for cell in before]
    for robot, size in enumerate(sizes):
        ways[robot] = [cell for cell in ways[robot] if cell == before[robot] or not roadmap.barred[size, cell]]
    for after in itertools.product(*ways):
        if len(set(after)) == len(after) and not has_ring(before, after) and has_room(roadmap, before, after):
            yield after


def has_room(roadmap: Roadmap, before: Cells, after: Cells) -> bool:
    """Return whether each area that robots enter has room for them and all that were in it before."""
    for area, room in enumerate(roadmap.room):
        inside = {cell for cell in (*before, *after) if int(roadmap.areas[cell]) >> area & 1}
        entering = sum(there in inside and here not in inside for here, there in zip(before, after, strict=True))
        if entering and entering + sum(here in inside for here in before) > room:
            return False
    return True


def has_ring(before: Cells, after: Cells) -> bool:
    """Return whether robots exchange their cells, two or more in a closed ring."""
    follows = {here: there for here, there in zip(before, after, strict=True) if here != there}
    for first in follows:
        cell = first
        for _ in follows:
            cell = follows.get(cell, -1)
            if cell == first:
                return True
    return False
