"""Small halls with robots, at random."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray

from ppaas.fleet.roadmap import Roadmap


class Hall(NamedTuple):
    """A roadmap, and the cells where robots start and want to go."""

    roadmap: Roadmap
    starts: list[int]
    goals: list[int]

    def places(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return rows and columns of starts and goals."""
        cells = self.roadmap.cells.astype(np.int64)
        return cells[self.starts].reshape(-1, 2), cells[self.goals].reshape(-1, 2)


@st.composite
def halls(draw: st.DrawFn, most_cells: int = 12, most_robots: int = 3) -> Hall:
    """Return halls of up to so many rows and columns together, not all of whose parts are connected."""
    height = draw(st.integers(1, 4))
    width = draw(st.integers(1, max(1, most_cells // height)))
    free = np.array(
        draw(st.lists(st.sampled_from([True, True, True, False]), min_size=height * width, max_size=height * width))
    )
    free[0] = True
    roadmap = Roadmap.of_grid(free.reshape(height, width))
    count = draw(st.integers(1, min(most_robots, len(roadmap))))
    starts, goals = [draw(st.permutations(range(len(roadmap))))[:count] for _ in range(2)]
    return Hall(roadmap, starts, goals)


@st.composite
def ruled_halls(draw: st.DrawFn, most_cells: int = 10, most_robots: int = 3) -> Hall:
    """Return halls in which some moves are one-way, and some areas have room for few robots."""
    hall = draw(halls(most_cells, most_robots))
    size = len(hall.roadmap)
    closed = draw(st.lists(st.sampled_from([True, False, False, False]), min_size=4 * size, max_size=4 * size))
    room = draw(st.lists(st.integers(1, 2), max_size=2))
    areas = draw(st.lists(st.integers(0, 2 ** len(room) - 1), min_size=size, max_size=size))
    roadmap = hall.roadmap.without_moves(np.array(closed).reshape(size, 4))
    roadmap = replace(roadmap, areas=np.array(areas, np.uint64), room=np.array(room, np.int32))
    return hall._replace(roadmap=roadmap)


@st.composite
def mixed_halls(draw: st.DrawFn, most_cells: int = 10, most_robots: int = 3) -> tuple[Hall, NDArray[np.int8]]:
    """Return halls with cells that robots of size 1 do not enter, and the size of each robot."""
    hall = draw(halls(most_cells, most_robots))
    count, cells = len(hall.starts), len(hall.roadmap)
    narrow = np.array(draw(st.lists(st.sampled_from([False, False, True]), min_size=cells, max_size=cells)))
    sizes = np.array(draw(st.lists(st.integers(0, 1), min_size=count, max_size=count)), np.int8)
    roadmap = replace(hall.roadmap, barred=np.stack([np.zeros(cells, np.bool_), narrow]))
    return hall._replace(roadmap=roadmap), sizes


def hall_of(text: str) -> Hall:
    """Return a hall from a drawing.

    ``#`` is blocked; a lower-case letter is the start of a robot, the upper-case one its goal; ``.`` is neither.
    """
    rows = [line.strip() for line in text.strip().splitlines()]
    roadmap = Roadmap.of_grid(np.array([[mark != "#" for mark in row] for row in rows]))
    marks = {mark: int(roadmap.numbers[y, x]) for y, row in enumerate(rows) for x, mark in enumerate(row)}
    robots = sorted(mark for mark in marks if mark.islower())
    return Hall(roadmap, [marks[robot] for robot in robots], [marks[robot.upper()] for robot in robots])
