"""Cases that users of other systems of traffic have reported: robots that wait for each other for ever."""

from typing import NamedTuple

from benchmarks.fleet.stand_ins.simulation import Simulation, roadmap_of

Place = tuple[int, int]


class ReportedCase(NamedTuple):
    """A hall in text, and starts and goals of robots, as row and column; a robot without a goal is idle.

    Parameters
    ----------
    name : str
    hall : str
    robots : tuple
    """

    name: str
    hall: str
    robots: tuple[tuple[Place, Place | None], ...]

    @property
    def goals(self) -> int:
        """Number of goals."""
        return sum(goal is not None for _, goal in self.robots)

    def simulation(self, seed: int) -> Simulation:
        """Return its simulation."""
        hall = roadmap_of(self.hall)
        simulation = Simulation(hall, seed)
        for start, goal in self.robots:
            simulation.add(int(hall.roadmap.numbers[start]), None if goal is None else int(hall.roadmap.numbers[goal]))
        return simulation


CASES = (
    ReportedCase("head-on, with a bay", "........\n###.####", (((0, 0), (0, 7)), ((0, 7), (0, 0)))),
    ReportedCase("a swap with one niche", ".....\n#.###", (((0, 0), (0, 4)), ((0, 4), (0, 0)))),
    ReportedCase(
        "a crossing",
        "###.###\n###.###\n.......\n###.###\n###.###",
        (((2, 0), (2, 6)), ((2, 6), (2, 0)), ((0, 3), (4, 3)), ((4, 3), (0, 3))),
    ),
    ReportedCase("an idle robot in the way", ".......\n###.###", (((0, 0), (0, 6)), ((0, 3), None))),
)
