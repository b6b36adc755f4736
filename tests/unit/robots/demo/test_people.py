import numpy as np

from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.people_coordination import FollowOrder, PeopleState
from robots.demo.demonstration import DemoOptions
from robots.demo.people import set_stage, tell


def test_the_stage_has_the_robots_and_people_asked_for() -> None:
    stage = set_stage(DemoOptions(robots=2, people=4, seed=3))
    assert (stage.map_id, stage.robots) == ("office", ["turtlebot-1", "turtlebot-2"])
    assert len(stage.scene.world.people()) == 4
    assert all(robot.model.camera is not None for robot in stage.scene.world.robots)
    without = set_stage(DemoOptions(robots=1, people=1, seed=3, sensor="laser"))
    assert without.scene.world.robots[0].model.camera is None


def test_furniture_does_not_lock_robots_into_a_part_of_the_office() -> None:
    # In this office, a table may close the corridor.
    stage = set_stage(DemoOptions(robots=2, people=3, seed=2))
    places = np.array([stage.scene.ways.anywhere()[:2] for _ in range(100)])
    assert (np.ptp(places, axis=0) > (10.0, 7.0)).all()


def test_only_changes_are_written() -> None:
    lines: list[str] = []
    order = FollowOrder("tb1", 4, 2.5, Time(), "cheapest path")
    none, one = PeopleState(Header(), 0), PeopleState(Header(), 1, orders=[order])
    tell(none, none, lines.append)
    tell(none, one, lines.append)
    tell(one, one, lines.append)
    assert lines == ["1 people are seen", "tb1 follows person 4: cheapest path"]
