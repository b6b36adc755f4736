import math

import numpy as np
import pytest

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo
from ppaas.messages.people_coordination import SensorView
from robots.demo.people_world import HIDING, PERHAPS, Occluders, PeopleWorld, build_world, present, visible_shares
from robots.sim.bodies.furniture import CHAIR
from robots.sim.depth.camera import DepthCameraModel
from tests.support.world.rooms import room

GRID = room(9.0, 7.0)


def built(seed: int = 1) -> PeopleWorld:
    camera = DepthCameraModel(width=32, height=24)
    return build_world(GRID, 2, 5, camera, np.random.default_rng(seed))


@pytest.fixture(scope="module")
def stage() -> PeopleWorld:
    return built()


def test_robots_people_and_furniture_stand_apart_on_free_floor(stage: PeopleWorld) -> None:
    robots = np.array([robot.base.pose[:2] for robot in stage.world.robots])
    people = present(stage.world)
    assert len(robots) == 2
    assert people.shape == (5, 2)
    assert np.hypot(*(robots[:, None] - people).transpose(2, 0, 1)).min() > 0.5
    assert all(stage.ways.allows(x, y) for x, y in robots.tolist())
    # One person sits, and there are chairs for others.
    assert sum(piece.kind == CHAIR for piece in stage.world.furniture) == 3


def test_furniture_is_in_the_mask_and_what_is_tall_hides_people(stage: PeopleWorld) -> None:
    for piece in stage.world.furniture:
        assert stage.keepout.data[GRID.info.cell_of(piece.pose.x, piece.pose.y)] == 100
    assert len(stage.surroundings.discs) == sum(piece.kind in HIDING for piece in stage.world.furniture)


def test_the_same_seed_gives_the_same_world_and_another_seed_another(stage: PeopleWorld) -> None:
    ends = []
    for each in (stage, built(1), built(2)):
        for _ in range(50):
            each.world.step()
        ends.append(present(each.world))
    assert ends[0] == pytest.approx(ends[1], nan_ok=True)
    assert ends[0] != pytest.approx(ends[2], nan_ok=True)


VIEW = SensorView(0.0, 0.0, 0.0, math.radians(57.0), 0.5, 5.0)
INFO = GridInfo(0.05, 200, 200, Pose2D(-5.0, -5.0))
ROBOT = Pose2D(0.0, 0.0)


def shares(*people: tuple[float, float], walls: np.ndarray | None = None, discs: tuple = ()) -> list[float]:
    occupied = np.zeros(INFO.shape, bool) if walls is None else walls
    return visible_shares(Occluders(occupied, INFO, discs), ROBOT, [VIEW], np.array(people)).tolist()


def test_a_person_in_front_is_wholly_in_view_and_one_far_out_of_range_or_behind_is_not() -> None:
    assert shares((2.0, 0.0), (7.6, 0.0), (0.3, 1.0), (-2.0, 0.0)) == [1.0, 0.0, 0.0, 0.0]


def test_people_a_little_out_of_range_are_less_than_half_in_view() -> None:
    assert shares((5.2, 0.0)) == shares((0.4, 0.0)) == [PERHAPS]


def test_half_of_a_person_on_the_edge_of_the_field_of_view_is_in_view() -> None:
    edge = 3.0 * math.cos(VIEW.field_of_view / 2), 3.0 * math.sin(VIEW.field_of_view / 2)
    assert shares(edge)[0] == pytest.approx(0.5, abs=0.1)


def test_a_wall_and_another_person_and_furniture_hide_a_person() -> None:
    walls = np.zeros(INFO.shape, bool)
    walls[:, 130] = True  # at x = 1.5 m
    assert shares((2.0, 0.0), walls=walls) == [0.0]
    assert shares((2.0, 0.0), (1.0, 0.0)) == [0.0, 1.0]
    assert shares((3.0, 0.0), discs=((np.array([[1.5, 0.0]]), 0.3),)) == [0.0]


def test_a_person_who_is_half_behind_another_is_half_in_view() -> None:
    assert 0.3 < shares((3.0, 0.0), (1.5, 0.2))[0] < 0.7


def test_a_person_whose_sides_are_beside_another_who_may_stand_sideways_is_perhaps_in_view() -> None:
    assert 0.0 < shares((3.4, 0.0), (2.4, 0.0))[0] <= PERHAPS
    assert shares((3.0, 0.0), (1.0, 0.0))[0] == 0.0
