"""Navigation by REST: goals and poses of robots, the robots that are followed, and the time until they are not."""

import json
from typing import Any

import pytest

from engine.control import robot_navigation
from engine.control.robot_navigation import MAX_ACTIVE, MAX_ENDED, POSE_AGE, NavigationClient, RobotNavigation
from engine.control.views import NavigationState
from engine.links.presence import Presence, RobotPresence
from engine.master.places import robot_key
from engine.protocols import robot_link
from engine.protocols.refusals import Refusal
from ppaas.clock import ManualClock
from ppaas.errors import Conflict, NotFound, QuotaExceeded, Unavailable
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import Status
from ppaas.navigation.goal_watch import MIN_LISTS, SETTLED
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
        self.ended: list[tuple[str, str]] = []

    def place(self, key: str) -> StillRobot | None:
        return self.places.get(key)


@pytest.fixture
def driver() -> FakeDriver:
    return FakeDriver()


@pytest.fixture
def navigation(driver: FakeDriver, monkeypatch: pytest.MonkeyPatch) -> RobotNavigation:
    monkeypatch.setattr(robot_navigation, "POSE_TIMEOUT", 0.01)
    return RobotNavigation(driver, lambda key, goal: driver.ended.append((key, goal.state)))  # type: ignore[arg-type]


async def test_a_robot_that_is_not_connected_has_a_state_and_takes_no_goals(navigation: RobotNavigation) -> None:
    assert await navigation.state("ann", "tb2") == NavigationState(connected=False)
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
    assert driver.ended == [(KEY, "lost")]
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


POSE = {"position": {"x": 1.0, "y": 2.0, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}
HERE = Presence(connected=True)
HEADER = {"stamp": {"secs": 1, "nsecs": 0}, "frame_id": "map"}


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock(1000.0)


@pytest.fixture
def place() -> StillRobot:
    return StillRobot()


@pytest.fixture
async def client(place: StillRobot, clock: ManualClock) -> NavigationClient:
    return NavigationClient(place, clock, monotonic=clock)


def status(goal: str, state: Status, text: str = "") -> dict[str, Any]:
    return {"goal_id": {"stamp": {"secs": 0, "nsecs": 0}, "id": goal}, "status": int(state), "text": text}


def report(place: StillRobot, *statuses: dict[str, Any]) -> None:
    place.publish_json("move_base/status", {"header": HEADER, "status_list": list(statuses)})


def delivered(place: StillRobot, topic: str) -> list[dict[str, Any]]:
    frames = place.far.take(robot_link.Deliver)
    return [json.loads(frame.payload) for frame in frames if frame.topic == topic]


async def test_a_goal_reaches_move_base_and_is_followed_to_its_end(
    place: StillRobot, client: NavigationClient, clock: ManualClock
) -> None:
    goal = client.send(Pose2D(4.0, 1.5, 0.0))
    assert (goal.state, goal.pose, goal.sent, goal.ended) == ("pending", (4.0, 1.5, 0.0), 1000.0, None)
    [sent] = delivered(place, "move_base/goal")
    assert sent["goal_id"]["id"] == goal.id
    assert sent["goal"]["target_pose"]["header"]["frame_id"] == "map"
    assert sent["goal"]["target_pose"]["pose"]["position"]["x"] == 4.0
    report(place, status(goal.id, Status.ACTIVE, "waiting: no scan"))
    assert (client.goal(goal.id).state, client.goal(goal.id).text) == ("active", "waiting: no scan")
    clock.advance(3.0)
    place.publish_json("move_base/result", {"header": HEADER, "status": status(goal.id, Status.SUCCEEDED, "reached")})
    ended = client.goal(goal.id)
    assert (ended.state, ended.text, ended.ended) == ("succeeded", "reached", 1003.0)
    assert client.active() == [] and client.goals() == [ended]


@pytest.mark.parametrize(
    ("final", "state"),
    [
        (Status.PREEMPTED, "canceled"),
        (Status.RECALLED, "canceled"),
        (Status.ABORTED, "aborted"),
        (Status.REJECTED, "rejected"),
        (Status.LOST, "lost"),
    ],
)
async def test_a_status_ends_a_goal_whose_result_is_missing(
    place: StillRobot, client: NavigationClient, final: Status, state: str
) -> None:
    goal = client.send(Pose2D(4.0, 1.5))
    report(place, status(goal.id, final, "why"))
    assert (client.goal(goal.id).state, client.goal(goal.id).text) == (state, "why")
    report(place, status(goal.id, Status.ACTIVE))
    assert client.goal(goal.id).state == state, "an ended goal does not begin again"


async def test_a_goal_that_move_base_does_not_list_is_lost_after_a_while(
    place: StillRobot, client: NavigationClient, clock: ManualClock
) -> None:
    goal = client.send(Pose2D(4.0, 1.5))
    for _ in range(MIN_LISTS - 1):
        report(place)
        clock.advance(SETTLED)
    assert client.goal(goal.id).state == "pending"
    report(place)
    assert client.goal(goal.id).state == "lost"


async def test_a_goal_is_not_lost_by_one_list_after_a_pause(
    place: StillRobot, client: NavigationClient, clock: ManualClock
) -> None:
    goal = client.send(Pose2D(4.0, 1.5))
    report(place, status(goal.id, Status.ACTIVE))
    clock.advance(100.0 * SETTLED)  # its container was replaced, and no list came
    report(place)
    assert client.goal(goal.id).state == "active"


async def test_a_clock_that_is_set_loses_no_goal(place: StillRobot) -> None:
    wall, elapsed = ManualClock(1000.0), ManualClock(0.0)
    client = NavigationClient(place, wall, monotonic=elapsed)
    goal = client.send(Pose2D(4.0, 1.5))
    for _ in range(10 * MIN_LISTS):
        wall.advance(3600.0)
        report(place)
    assert client.goal(goal.id).state == "pending"


async def test_a_goal_that_the_clone_refuses_is_rejected_with_its_reason(
    place: StillRobot, client: NavigationClient
) -> None:
    goal = client.send(Pose2D(4.0, 1.5))
    [deliver] = place.far.take(robot_link.Deliver)
    refusal = Refusal("invalid-input", "the goal is outside the map")
    place.say(robot_link.MessageRefused(deliver.client, deliver.topic, refusal, deliver.sequence))
    assert (client.goal(goal.id).state, client.goal(goal.id).text) == ("rejected", "the goal is outside the map")


async def test_cancelling_names_the_goal_or_all_of_them(place: StillRobot, client: NavigationClient) -> None:
    goal = client.send(Pose2D(4.0, 1.5))
    assert client.cancel(goal.id).state == "pending"
    client.cancel_all()
    assert [cancel["id"] for cancel in delivered(place, "move_base/cancel")] == [goal.id, ""]
    with pytest.raises(NotFound):
        client.cancel("rest-unknown")
    report(place, status(goal.id, Status.PREEMPTED))
    with pytest.raises(Conflict, match="has ended: canceled"):
        client.cancel(goal.id)


async def test_goals_are_bounded(place: StillRobot, client: NavigationClient) -> None:
    for _ in range(MAX_ENDED + 10):
        report(place, status(client.send(Pose2D(4.0, 1.5)).id, Status.PREEMPTED))
    for _ in range(MAX_ACTIVE):
        client.send(Pose2D(4.0, 1.5))
    with pytest.raises(QuotaExceeded, match="active goals"):
        client.send(Pose2D(4.0, 1.5))
    assert len(client.goals()) == MAX_ENDED + MAX_ACTIVE


async def test_the_state_has_the_last_pose_and_why_there_is_none(
    place: StillRobot, client: NavigationClient, clock: ManualClock
) -> None:
    place.publish_json("amcl/status", {"data": "no odometry"})
    state = client.state(HERE)
    assert (state.pose, state.pose_at, state.localization) == (None, None, "no odometry")
    place.publish_json("amcl/status", {"data": ""})
    place.publish_json("grid_slam/status", {"data": "mapping is paused"})
    assert client.state(HERE).localization == "mapping is paused"
    place.publish_json("grid_slam/status", {"data": ""})
    place.publish_json("amcl_pose", {"header": HEADER, "pose": {"pose": POSE}})
    goal = client.send(Pose2D(4.0, 1.5))
    state = client.state(HERE)
    assert client.localized.is_set()
    assert (state.pose, state.pose_at, state.localization, state.goals) == ((1.0, 2.0, 0.0), 1000.0, "", (goal,))


async def test_a_pose_that_is_not_renewed_is_not_where_the_robot_is(
    place: StillRobot, client: NavigationClient, clock: ManualClock
) -> None:
    assert client.place_now is None and client.localization == ""
    place.publish_json("amcl_pose", {"header": HEADER, "pose": {"pose": POSE}})
    clock.advance(POSE_AGE)
    assert client.place_now == (1.0, 2.0, 0.0) and client.state(HERE).localization == ""
    clock.advance(2.0)
    assert client.place_now is None
    assert client.state(HERE).localization == f"no pose has come for {POSE_AGE + 2.0:.0f} s"
    place.publish_json("amcl/status", {"data": "no scan comes any more"})
    assert client.state(HERE).localization == "no scan comes any more"
    place.publish_json("amcl/status", {"data": ""})
    place.publish_json("amcl_pose", {"header": HEADER, "pose": {"pose": POSE}})
    assert client.state(HERE).localization == ""


async def test_a_closed_place_ends_its_goals(place: StillRobot, client: NavigationClient) -> None:
    goal = client.send(Pose2D(4.0, 1.5))
    place.close(Unavailable("no client was connected for 30 s"))
    assert (client.goal(goal.id).state, client.goal(goal.id).text) == ("lost", "no client was connected for 30 s")


async def test_a_client_that_left_hears_nothing(place: StillRobot, client: NavigationClient) -> None:
    client.leave()
    place.publish_json("amcl_pose", {"header": HEADER, "pose": {"pose": POSE}})
    assert client.state(HERE).pose is None and place.heard() == frozenset()
