"""Robots with real clones in simulated halls: goals, contacts and waits, beside robots that are alone."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

from benchmarks.fleet.traffic.scene import TrafficScene
from benchmarks.harness.drawn_lanes import LANES, zones_of_hall
from benchmarks.harness.figures import Figure
from benchmarks.harness.goal_places import distance_figure
from ppaas.errors import InvalidInput
from ppaas.maps.generate import office, warehouse
from ppaas.maps.grid import GridMap

PART = "traffic"

HALLS: dict[str, Callable[[int], GridMap]] = {
    "warehouse": warehouse,
    "office": office,
    "large-office": partial(office, width=48.0, height=32.0),
    LANES: partial(warehouse, width=40.0),
}
"""Halls that are made up, by name."""

SHARE = 0.75
"""Least part of the goals of robots that are alone."""

ALONE = 6
"""Number of robots that are each alone, whose mean number of goals is the baseline: goals are drawn near and far."""

WAITS = 5.0
"""Largest ratio of the longest time of a goal to the mean."""


@dataclass(frozen=True, slots=True)
class TrafficCase:
    """Robots in a hall for some time.

    Parameters
    ----------
    hall : str
        Name of a hall of `HALLS`.
    robots : int
    seconds : float
        Simulated time [s].
    seed : int
    """

    hall: str
    robots: int
    seconds: float
    seed: int = 1

    def grid(self) -> GridMap:
        """Return the map of the hall."""
        return HALLS[self.hall](self.seed)


def case_of(words: list[str]) -> TrafficCase:
    """Return the case of the words on a command line: hall, robots, minutes, seed.

    Raises
    ------
    InvalidInput
        There is no such hall, or a number is not one.
    """
    hall, robots, minutes, seed = words
    if hall not in HALLS:
        raise InvalidInput(f"there is no hall {hall!r}; choose one of {', '.join(HALLS)}")
    try:
        return TrafficCase(hall, int(robots), 60.0 * float(minutes), int(seed))
    except ValueError as error:
        raise InvalidInput(f"robots, minutes and seed must be numbers: {error}") from error


def measure(case: TrafficCase) -> Iterator[Figure]:
    """Run robots by the traffic of their map, and some robots that are each alone."""
    grid = case.grid()
    scene = _run(TrafficScene(grid, case.robots, case.seed, zones=zones_of_hall(case.hall, grid)), case.seconds)
    seeds = range(case.seed, case.seed + ALONE)
    alone = sum(_run(TrafficScene(grid, 1, seed), case.seconds).outcome().goals for seed in seeds) / ALONE
    got, name = scene.outcome(), f"{case.hall}, {case.robots}, seed {case.seed}"
    share = got.goals / max(alone * case.robots, 1.0)
    yield Figure(PART, f"{name}: contacts of robots", got.contacts, "", limit=0.0, note=f"nearest {got.nearest:g} m")
    yield Figure(PART, f"{name}: contacts with walls", got.walls, "", limit=0.0)
    yield Figure(
        PART, f"{name}: goals", got.goals, "", limit=SHARE * alone * case.robots, floor=True,
        note=f"{share:.0%} of {case.robots} robots that are each alone ({alone:g} goals each, by {ALONE})",
    )  # fmt: skip
    yield Figure(PART, f"{name}: goals that ended otherwise", got.failed, "", limit=0.0, note="; ".join(scene.reasons))
    yield Figure(
        PART, f"{name}: longest open goal", got.longest, "s", limit=round(WAITS * got.mean, 1),
        note=f"mean of those reached {got.mean:g} s",
    )  # fmt: skip
    if got.misses:
        yield distance_figure(PART, name, got.misses)


def _run(scene: TrafficScene, seconds: float) -> TrafficScene:
    while scene.world.time() < seconds:
        scene.step()
    return scene
