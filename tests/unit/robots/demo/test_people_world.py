import numpy as np
import pytest

from robots.demo.people_world import HIDING, PeopleWorld, build_world, present
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
