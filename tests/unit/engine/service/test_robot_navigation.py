"""Navigation by REST: the robots that are followed, and the time until they no longer are."""

import pytest

from engine.master.places import robot_key
from engine.service import robot_navigation
from engine.service.links.presence import RobotPresence
from engine.service.robot_navigation import RobotNavigation
from engine.service.views import RobotState
from ppaas.clock import ManualClock
from ppaas.errors import NotFound, Unavailable
from ppaas.geometry import Pose2D
from tests.support.endpoints.still_place import StillRobot
from tests.support.waiting import until

KEY = robot_key("ann", "tb1")


class FakeDriver:
    """Has the places that the test gives it."""

    def __init__(self) -> None:
        self.places = {KEY: StillRobot()}
        self.places[KEY].container = "c1"
        self.presence = RobotPresence(self.place, ManualClock(1000.0))
        self.presence.came(KEY)

    def place(self, key: str) -> StillRobot | None:
        return self.places.get(key)


@pytest.fixture
def driver() -> FakeDriver:
    return FakeDriver()


@pytest.fixture
def navigation(driver: FakeDriver, monkeypatch: pytest.MonkeyPatch) -> RobotNavigation:
    monkeypatch.setattr(robot_navigation, "POSE_TIMEOUT", 0.01)
    return RobotNavigation(driver)  # type: ignore[arg-type]


async def test_a_robot_that_is_not_connected_has_a_state_and_takes_no_goals(navigation: RobotNavigation) -> None:
    assert await navigation.state("ann", "tb2") == RobotState(connected=False)
    assert await navigation.goals("ann", "tb2") == []
    with pytest.raises(Unavailable, match="robot 'tb2' is not connected"):
        await navigation.send_goal("ann", "tb2", Pose2D(1.0, 2.0))
    with pytest.raises(Unavailable):
        await navigation.cancel_goals("ann", "tb2")
    with pytest.raises(NotFound):
        await navigation.goal("ann", "tb2", "rest-1")


async def test_a_robot_that_left_is_not_connected_while_its_container_waits_for_it(
    navigation: RobotNavigation, driver: FakeDriver
) -> None:
    goal = await navigation.send_goal("ann", "tb1", Pose2D(1.0, 2.0))
    driver.presence.left(KEY)
    state = await navigation.state("ann", "tb1")
    assert (state.connected, state.disconnected_since, state.container) == (False, 1000.0, True)
    with pytest.raises(Unavailable, match="robot 'tb1' is not connected"):
        await navigation.send_goal("ann", "tb1", Pose2D(1.0, 2.0))
    assert await navigation.cancel_goal("ann", "tb1", goal.id) == goal
    await navigation.cancel_goals("ann", "tb1")
    driver.presence.came(KEY)
    state = await navigation.state("ann", "tb1")
    assert (state.connected, state.disconnected_since, state.container) == (True, None, True)
    navigation.close()


async def test_requests_of_one_robot_share_a_client(navigation: RobotNavigation, driver: FakeDriver) -> None:
    goal = await navigation.send_goal("ann", "tb1", Pose2D(1.0, 2.0))
    assert (await navigation.state("ann", "tb1")).goals == (goal,)
    assert await navigation.goals("ann", "tb1") == [goal] == [await navigation.goal("ann", "tb1", goal.id)]
    assert await navigation.cancel_goal("ann", "tb1", goal.id) == goal
    assert driver.places[KEY].clients == 1
    navigation.close()
    assert driver.places[KEY].clients == 0


async def test_goals_of_a_closed_place_are_shown_until_the_robot_connects_again(
    navigation: RobotNavigation, driver: FakeDriver
) -> None:
    goal = await navigation.send_goal("ann", "tb1", Pose2D(1.0, 2.0))
    driver.places.pop(KEY).close(Unavailable("gone"))
    assert (await navigation.goal("ann", "tb1", goal.id)).state == "lost"
    driver.places[KEY] = StillRobot()
    assert (await navigation.state("ann", "tb1")).goals == ()
    assert await navigation.goals("ann", "tb1") == []
    navigation.close()


async def test_a_robot_is_followed_while_it_has_a_goal_or_is_asked_for(
    navigation: RobotNavigation, driver: FakeDriver, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(robot_navigation, "IDLE", 0.02)
    place = driver.places[KEY]
    goal = await navigation.send_goal("ann", "tb1", Pose2D(1.0, 2.0))
    navigation._check_idle(KEY)
    assert place.clients == 1
    result = {"goal_id": {"id": goal.id}, "status": 3, "text": ""}
    place.publish_json("move_base/result", {"header": {"frame_id": ""}, "status": result})
    await until(lambda: place.clients == 0)
    assert await navigation.goals("ann", "tb1") == []
