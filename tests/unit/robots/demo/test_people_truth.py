import numpy as np
import pytest

from ppaas.geometry import Pose2D
from ppaas.messages.people_coordination import SensorView
from robots.demo.people_truth import TruthRecorder
from robots.demo.people_world import PeopleWorld, Surroundings
from robots.sim.shortest_paths import ShortestPaths
from robots.sim.world import World
from tests.support.world.rooms import room


@pytest.fixture
def stage() -> PeopleWorld:
    """Return a world with one robot, a person ahead of it, and one behind it."""
    grid = room(8.0, 6.0)
    world, ways = World(grid, epoch=100.0), ShortestPaths(grid, 0.35, np.random.default_rng(1))
    world.add_robot(Pose2D(3.0, 3.0))
    for x in (5.0, 1.0):
        world.add_actor(ways, Pose2D(x, 3.0), iter([]))
    return PeopleWorld(world, grid, Surroundings(world.occupied, grid.info), ways)


def test_the_truth_is_kept_for_states_that_arrive_later(stage: PeopleWorld) -> None:
    recorder = TruthRecorder(stage, ["tb1"])
    recorder.views["tb1"] = [SensorView(0.0, 0.0, 0.0, 1.0, 0.5, 5.0)]
    for _ in range(100):
        stage.world.step()
        recorder.step()
    truth = recorder.at(101.03)
    assert truth is not None
    assert truth.time == pytest.approx(1.0, abs=0.08)
    assert truth.shares.tolist() == [1.0, 0.0]
    assert truth.robots["tb1"] == pytest.approx((3.0, 3.0))
    assert recorder.at(90.0) is None
    assert recorder.at(103.0) is None


def test_contacts_that_a_robot_causes_are_counted_from_the_beginning_of_the_score(stage: PeopleWorld) -> None:
    recorder = TruthRecorder(stage, ["tb1"])
    recorder.begin()
    [robot] = stage.world.robots
    robot.base.carry_to(Pose2D(4.7, 3.0))
    for _ in range(2):
        stage.world.step()
        recorder.step()
    assert recorder.contacts() == 0, "the robot did not drive"
    robot.base.carry_to(Pose2D(0.1, 3.0))
    stage.world.step()
    recorder.step()
    assert recorder.contacts() == 1
    recorder.begin()
    assert recorder.contacts() == 0
