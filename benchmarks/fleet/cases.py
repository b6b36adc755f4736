"""Cases of the fleet bench: halls that are made up, and maps with scenarios of the MovingAI benchmarks."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.fleet.kernels.board import UNREACHABLE
from ppaas.fleet.problem import FleetProblem, distances_from
from ppaas.fleet.roadmap import Roadmap
from robots.plans.fleet import read_problem

SEED = 1
AISLES, AISLE_LENGTH, SHELF = 20, 40, 10
"""Number of aisles of the hall, their length, and the length of a shelf [cells]."""

SHELF_ROWS, SHELVES, LANE, BESIDE_SHELVES = 40, 20, 2, 50
"""Number of rows of shelves in the warehouse, of shelves in a row, and of cells across a lane and at ends of rows."""


class Case(NamedTuple):
    """Robots on a map.

    Parameters
    ----------
    name : str
    map, scenario : Path, optional
        Files of MovingAI; None for a hall that is made up.
    robots : int
    """

    name: str
    map: Path | None
    scenario: Path | None
    robots: int

    def read(self) -> FleetProblem:
        """Return the problem.

        Raises
        ------
        InvalidInput, NoValidPath
            A file cannot be read, or a robot has no way.
        """
        if self.map is not None and self.scenario is not None:
            return read_problem(self.map, self.scenario, self.robots)
        roadmap = HALLS[self.name]()
        starts, goals = [roadmap.cells[cells].astype(np.int64) for cells in drawn(roadmap, self.robots)]
        return FleetProblem.of(roadmap, starts, goals)


def rubble() -> Roadmap:
    """Return a square of 32 by 32 cells, a fifth of which is blocked at random."""
    free = np.random.default_rng(SEED).random((32, 32)) > 0.2
    free[16] = True
    return Roadmap.of_grid(free)


def aisles() -> Roadmap:
    """Return a hall of shelves with lanes of one cell between them, and cross lanes."""
    free = np.ones((2 * AISLES + 9, AISLE_LENGTH + 8), np.bool_)
    rows = np.arange(4, 2 * AISLES + 4, 2)
    columns = np.array([column for column in range(4, AISLE_LENGTH + 4) if (column - 3) % (SHELF + 1)])
    free[np.ix_(rows, columns)] = False
    return Roadmap.of_grid(free)


def warehouse() -> Roadmap:
    """Return a large hall of shelves of two rows, with lanes of two cells between them, and room around."""
    shelf = np.ones((LANE + 2, SHELF + LANE), np.bool_)
    shelf[LANE:, :SHELF] = False
    beside = (BESIDE_SHELVES, BESIDE_SHELVES)
    return Roadmap.of_grid(np.pad(np.tile(shelf, (SHELF_ROWS, SHELVES)), ((0, LANE), beside), constant_values=True))


HALLS = {"rubble": rubble, "aisles": aisles, "warehouse": warehouse}

MADE = (
    Case("rubble", None, None, 300),
    Case("aisles", None, None, 200),
    Case("warehouse", None, None, 1000),
)


def drawn(roadmap: Roadmap, robots: int) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Return starts and goals of robots, at random in the part of a roadmap around its middle."""
    height, width = roadmap.numbers.shape
    middle = roadmap.numbers[height // 2, :width]
    inside = middle[middle >= 0][:1]
    part = np.nonzero(distances_from(roadmap, inside)[0] < UNREACHABLE)[0].astype(np.int32)
    rng = np.random.default_rng(SEED)
    return rng.choice(part, robots, False), rng.choice(part, robots, False)


def case_of(words: Sequence[str]) -> Case:
    """Return a case from the command line: map, scenario and number of robots.

    Raises
    ------
    InvalidInput
        The number is none.
    """
    map_file, scenario, robots = words
    if not (robots.isdecimal() and int(robots)):
        raise InvalidInput(f"the number of robots must be a whole number of at least 1, not {robots!r}")
    return Case(Path(map_file).stem, Path(map_file), Path(scenario), int(robots))
