"""Cars of lifts on the cells of a fleet: who may enter which."""

import numpy as np

from ppaas.fleet.cell_rules import CellRules, rules_on
from ppaas.fleet.lattice_roadmap import LatticeRoadmap
from ppaas.fleet.roadmap import Roadmap
from ppaas.zones.shapes import LineString, Polygon
from ppaas.zones.zone import Door, LiftCar, Zone

ROW = LatticeRoadmap(Roadmap.of_grid(np.ones((1, 8), np.bool_)), 1.0, 0.0, 0.0)
"""Eight cells at x = 0 to 7 m."""


def car(name: str, low: float, high: float, door: float) -> list[Zone]:
    ring = [[low, -0.5], [high, -0.5], [high, 0.5], [low, 0.5], [low, -0.5]]
    return [
        Zone(Polygon([ring]), LiftCar(name=f"car {name}", lift=name)),
        Zone(LineString([[door, -0.5], [door, 0.5]]), Door(name=f"landing {name}", lift=name)),
    ]


def entered(rules: CellRules, at: int, goal: int | None, size: int = 0) -> list[int]:
    """Return the cells that a robot enters."""
    return np.nonzero(~rules.roadmap.barred[rules.kind(size, at, goal)])[0].tolist()


def test_robots_enter_the_car_of_their_goal_alone_and_without_a_goal_stay_in_it() -> None:
    rules = rules_on(ROW, [*car("west", -0.5, 1.5, 1.9), *car("east", 5.7, 7.5, 5.2)], 0.3)
    assert rules.cars == (frozenset({5, 6, 7}), frozenset({0, 1, 2})), "doors are parts of them, in the order of ids"
    outside, everywhere = [3, 4], list(range(8))
    assert entered(rules, 3, None) == entered(rules, 3, 4) == outside
    assert entered(rules, 3, 0) == [0, 1, 2, 3, 4] and entered(rules, 4, 7) == [3, 4, 5, 6, 7]
    assert entered(rules, 1, 4) == [0, 1, 2, 3, 4], "it leaves"
    assert entered(rules, 1, None) == entered(rules, 2, None) == [0, 1, 2], "the doors may be shut"
    assert entered(rules, 6, None) == [5, 6, 7]
    assert not len(rules_on(ROW, [], 0.3).roadmap.barred) and rules_on(ROW, [], 0.3).kind(2, 0, 1) == 2
    assert everywhere == sorted({*entered(rules, 1, 4), *entered(rules, 6, 4)})


def test_cells_that_are_too_narrow_for_a_size_stay_so() -> None:
    narrow = np.zeros((2, 8), np.bool_)
    narrow[1, 4] = True
    roadmap = Roadmap.of_grid(np.ones((1, 8), np.bool_))
    sizes = LatticeRoadmap(
        Roadmap(roadmap.neighbours, roadmap.incoming, roadmap.cells, roadmap.numbers, barred=narrow),
        1.0, 0.0, 0.0, radii=(0.2, 0.3),
    )  # fmt: skip
    rules = rules_on(sizes, car("west", -0.5, 1.5, 1.9), 0.3)
    assert entered(rules, 6, None) == [3, 4, 5, 6, 7]
    assert entered(rules, 6, None, size=1) == [3, 5, 6, 7]
    assert entered(rules, 6, 0, size=1) == [0, 1, 2, 3, 5, 6, 7]
