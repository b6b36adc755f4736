import itertools

import numpy as np
import pytest

from ppaas.buildings.layout import layout_of
from ppaas.errors import InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.maps.free_space import distance_to_occupied
from robots.demo.building_stage import FLOORS, PLACES, floor_map, record, set_stage, zones_of_floor
from robots.demo.options import DemoOptions


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_robots_have_room_at_all_places_and_before_and_in_the_lifts(seed: int) -> None:
    layout = layout_of(record(), {floor: zones_of_floor(floor) for floor in FLOORS})
    assert layout.warnings == ()
    assert sorted(layout.landings) == ["east", "west"]
    grid = floor_map(np.random.default_rng(seed))
    free = distance_to_occupied(grid)
    spots = [*PLACES, *(each.car for each in layout.landings["west"]), *(each.wait for each in layout.landings["east"])]
    for x, y, _ in spots:
        assert free[tuple(grid.info.to_cells((x, y)))] > 0.5, (x, y)


def test_robots_start_at_different_places_and_each_goal_is_on_another_floor_than_the_one_before() -> None:
    stage = set_stage(DemoOptions(robots=5, goals=3, seed=7))
    taken: list[set[tuple[str, Pose2D]]] = []
    for index, each in enumerate(stage.courses):
        robot = stage.simulated.robots[index]
        assert (stage.simulated.floor_of(robot), robot.base.pose) == (each.floors[-1], pytest.approx(each.course.start))
        floors = [each.floors[-1], *each.floors[:-1]]
        assert all(before != after for before, after in itertools.pairwise(floors))
        taken.append(set(zip(floors, (each.course.start, *each.course.goals), strict=True)))
    assert all(not first & second for first, second in itertools.combinations(taken, 2))


def test_one_seed_gives_one_stage() -> None:
    first, again, other = (set_stage(DemoOptions(seed=seed)) for seed in (3, 3, 4))
    assert first.courses == again.courses != other.courses
    assert all((first.grids[floor].data == again.grids[floor].data).all() for floor in FLOORS)


def test_the_store_and_the_landings_are_closed_at_first() -> None:
    stage = set_stage(DemoOptions(robots=1))
    world = stage.simulated.floors["L1"]
    for x, y in ((2.3, 4.5), (4.8, 7.9), (9.2, 7.9)):
        assert world.occupied[tuple(world.grid.info.to_cells((x, y)))]
    assert list(stage.simulated.doors) == [("L1", "store")]
    assert len(world.furniture) == 1, "the charger"


def test_more_robots_than_places_are_refused() -> None:
    with pytest.raises(InvalidParameter, match="room for 5 robots, not 6"):
        set_stage(DemoOptions(robots=6))
