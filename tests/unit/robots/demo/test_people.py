import asyncio

import numpy as np
import pytest

from ppaas.errors import Unavailable
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point
from ppaas.messages.people_coordination import FollowOrder, GroupRobot, PeopleState, SensorView, TrackedPerson
from robots.demo import people
from robots.demo.exploration import background
from robots.demo.options import DemoOptions
from robots.demo.people import PeopleStage, set_stage, write_changes
from robots.demo.people_patrol import is_wanted
from robots.demo.people_truth import TruthRecorder
from robots.demo.people_world import Occluders, PeopleWorld
from robots.sim.shortest_paths import ShortestPaths
from robots.sim.world import World
from tests.support.world.rooms import room


@pytest.fixture(scope="module")
def stage() -> PeopleStage:
    return set_stage(DemoOptions(robots=2, people=3, seed=2))


def test_the_stage_has_the_robots_and_people_of_the_options(stage: PeopleStage) -> None:
    assert (stage.map_id, stage.robots) == ("office", ["turtlebot-1", "turtlebot-2"])
    assert len(stage.scene.world.people()) == 3
    assert all(robot.model.camera is not None for robot in stage.scene.world.robots)
    without = set_stage(DemoOptions(robots=1, people=1, seed=3, sensor="laser"))
    assert without.scene.world.robots[0].model.camera is None


def test_furniture_does_not_lock_robots_into_a_part_of_the_office(stage: PeopleStage) -> None:
    # In this office, a table may close the corridor.
    places = np.array([stage.scene.ways.anywhere()[:2] for _ in range(100)])
    assert (np.ptp(places, axis=0) > (10.0, 7.0)).all()


def test_only_changes_are_written() -> None:
    lines: list[str] = []
    order = FollowOrder("tb1", 4, 2.5, Time(), "cheapest path")
    none, one = PeopleState(Header(), 0), PeopleState(Header(), 1, orders=[order])
    write_changes(none, none, lines.append)
    write_changes(none, one, lines.append)
    write_changes(one, one, lines.append)
    assert lines == ["1 person is seen", "tb1 follows person 4: cheapest path"]


async def test_a_demo_whose_robots_do_not_all_take_part_ends_with_the_reason(
    stage: PeopleStage, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(people, "START_TIMEOUT", 0.1)

    async def report() -> None:
        while True:
            stage.hear(PeopleState(Header(), 0, robots=[GroupRobot("turtlebot-1", Point(0.0, 0.0), 0.1)]))
            await asyncio.sleep(0.01)

    async with background(report()):
        with pytest.raises(Unavailable, match=r"within 0\.1 s: the coordinator hears \['turtlebot-1'\]"):
            await people.wait_for_robots(stage)


def person(*seen_by: str) -> TrackedPerson:
    return TrackedPerson(1, Point(0.0, 0.0), Point(0.0, 0.0), [0.01, 0.0, 0.0, 0.01], seen_by=list(seen_by))


@pytest.mark.parametrize(
    ("seen_by", "ordered", "wanted"),
    [((), "", False), (("tb1/4",), "", True), (("tb12/4",), "", False), ((), "tb1", True), ((), "tb2", False)],
)
def test_a_robot_that_sees_or_follows_somebody_does_not_patrol(
    seen_by: tuple[str, ...], ordered: str, wanted: bool
) -> None:
    orders = [FollowOrder(ordered, 1, 2.0, Time())] if ordered else []
    state = PeopleState(Header(), 1, [person(*seen_by)], orders)
    assert is_wanted("tb1", state) == wanted


@pytest.fixture
def truth_stage() -> PeopleWorld:
    """Return a world with one robot, a person ahead of it, and one behind it."""
    grid = room(8.0, 6.0)
    world, ways = World(grid, epoch=100.0), ShortestPaths(grid, 0.35, np.random.default_rng(1))
    world.add_robot(Pose2D(3.0, 3.0))
    for x in (5.0, 1.0):
        world.add_actor(ways, Pose2D(x, 3.0), iter([]))
    return PeopleWorld(world, grid, Occluders(world.occupied, grid.info), ways)


def test_the_truth_is_kept_for_states_that_arrive_later(truth_stage: PeopleWorld) -> None:
    recorder = TruthRecorder(truth_stage, ["tb1"])
    recorder.views["tb1"] = [SensorView(0.0, 0.0, 0.0, 1.0, 0.5, 5.0)]
    for _ in range(100):
        truth_stage.world.step()
        recorder.step()
    truth = recorder.at(101.03)
    assert truth is not None
    assert truth.time == pytest.approx(1.0, abs=0.08)
    assert truth.shares.tolist() == [1.0, 0.0]
    assert truth.robots["tb1"] == pytest.approx((3.0, 3.0))
    assert recorder.at(90.0) is None
    assert recorder.at(103.0) is None


def test_contacts_that_a_robot_causes_are_counted_from_the_beginning_of_the_score(truth_stage: PeopleWorld) -> None:
    recorder = TruthRecorder(truth_stage, ["tb1"])
    recorder.begin()
    [robot] = truth_stage.world.robots
    robot.base.carry_to(Pose2D(4.7, 3.0))
    for _ in range(2):
        truth_stage.world.step()
        recorder.step()
    assert recorder.contacts() == 0, "the robot did not drive"
    robot.base.carry_to(Pose2D(0.1, 3.0))
    truth_stage.world.step()
    recorder.step()
    assert recorder.contacts() == 1
    recorder.begin()
    assert recorder.contacts() == 0
