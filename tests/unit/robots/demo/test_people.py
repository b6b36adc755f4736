import asyncio

import numpy as np
import pytest

from ppaas.errors import Unavailable
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point
from ppaas.messages.people_coordination import FollowOrder, GroupRobot, PeopleState
from robots.demo import people
from robots.demo.exploration import background
from robots.demo.options import DemoOptions
from robots.demo.people import PeopleStage, set_stage, write_changes


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
