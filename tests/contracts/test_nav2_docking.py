"""Nav2's actions ``dock_robot`` and ``undock_robot`` over rosbridge, sent to a real clone with a simulated robot."""

from collections.abc import AsyncIterator

import pytest

from ppaas.geometry import Pose2D
from ppaas.messages.sensor_msgs import BatteryState
from ppaas.wire.actions import Part, part_of_action
from ppaas.zones.reading import zones_of
from tests.support.endpoints.driven_place import DrivenPlace
from tests.support.endpoints.nav2_frames import Json, goal, stamped
from tests.support.endpoints.still_place import StillClient
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.planar_world import World, walled_map

START, DOCKED = Pose2D(1.0, 1.0, 0.0), Pose2D(4.55, 2.0, 0.0)
GRID = walled_map(6.0, 4.0, [(4.75, 1.8, 5.0, 2.2)])
ZONES = b"""{"type": "FeatureCollection", "features": [
    {"type": "Feature", "properties": {"name": "home", "kind": "dock", "yaw": 0.0},
     "geometry": {"type": "Point", "coordinates": [4.55, 2.0]}},
    {"type": "Feature", "properties": {"name": "odd", "kind": "dock", "yaw": 0.0, "dock_type": "rocket"},
     "geometry": {"type": "Point", "coordinates": [2.0, 3.0]}}
]}"""
PARTS: tuple[Part, ...] = ("Goal", "Result", "Feedback")
TYPES = {"home_type": {"distance": 0.2}}


class Charged(DrivenPlace):
    """Place whose robot is charged within 4 cm of its dock, if anything charges it."""

    current = 2.0

    def run(self, seconds: float) -> None:
        """Simulate for a time, with readings of the battery twice a second [s]."""
        end = self.driving.clock() + seconds
        while self.driving.clock() < end:
            super().run(0.05)
            if round(self.driving.clock() / 0.05) % 10 == 0:
                near = self.driving.world.pose.distance_to(DOCKED) < 0.04
                state = BatteryState(current=self.current if near else -0.9, percentage=0.5)
                self.driving.graph.inject("battery_state", state)


@pytest.fixture
async def driven() -> Charged:
    place = Charged(
        ClosedLoop(
            World(GRID, START, beams=360), masks={"zones": zones_of(ZONES)},
            parameters={"docking_server": {"dock_types": TYPES}},
        )
    )  # fmt: skip
    place.run(0.3)
    return place


@pytest.fixture
async def navigator(driven: Charged) -> AsyncIterator[StillClient]:
    made = StillClient(driven, "operator")
    yield made
    made.session.end()


@pytest.mark.parametrize(
    ("action", "sent", "result", "feedback"),
    [
        (
            "DockRobot",
            ["use_dock_id", "dock_id", "dock_pose", "dock_type", "max_staging_time", "navigate_to_staging_pose"],
            ["success", "error_code", "num_retries", "error_msg"], ["state", "docking_time", "num_retries"],
        ),
        ("UndockRobot", ["dock_type", "max_undocking_time"], ["success", "error_code", "error_msg"], []),
    ],
)  # fmt: skip
def test_an_action_has_the_fields_of_nav2_in_their_order(
    action: str, sent: list[str], result: list[str], feedback: list[str]
) -> None:
    parts = [list(part_of_action(f"nav2_msgs/action/{action}", part).field_names()) for part in PARTS]
    assert parts == [sent, result, feedback]


async def test_a_robot_docks_is_charged_and_undocks(driven: Charged, navigator: StillClient) -> None:
    ended = driven.result(navigator, goal("dock_robot", "DockRobot", dock_id="home"), 120.0)
    assert (ended["status"], ended["values"]) == (
        4, {"success": True, "error_code": 0, "num_retries": 0, "error_msg": ""},
    )  # fmt: skip
    assert driven.driving.world.pose.distance_to(DOCKED) < 0.04
    states = [each["state"] for each in ended["feedback"]]
    assert states == sorted(states) and {1, 3, 4} <= set(states)
    ended = driven.result(navigator, goal("undock_robot", "UndockRobot"), 60.0)
    assert (ended["status"], ended["values"]["success"]) == (4, True)
    assert DOCKED.x - driven.driving.world.pose.x == pytest.approx(0.7, abs=0.06)


async def test_a_dock_may_be_given_by_its_pose(driven: Charged, navigator: StillClient) -> None:
    args = {"use_dock_id": False, "dock_pose": stamped(DOCKED.x, DOCKED.y), "dock_type": "home_type"}
    ended = driven.result(navigator, goal("dock_robot", "DockRobot", **args), 120.0)
    assert (ended["status"], ended["values"]["error_code"]) == (4, 0)


@pytest.mark.parametrize(
    ("args", "code", "reason"),
    [
        ({"dock_id": "garage"}, 901, "the map has no dock 'garage'; its docks: home, odd"),
        ({"dock_id": "odd"}, 902, "there is no dock_type 'rocket'"),
        ({"use_dock_id": False, "dock_pose": stamped(1.0, 1.0, frame="moon")}, 999, "moon"),
        ({"dock_id": "home", "max_staging_time": -1.0}, 999, "max_staging_time must be above 0 s"),
        ({"dock_id": "home", "max_staging_time": 1.0}, 903, "was not reached in 1 s"),
        ({"dock_id": "home", "navigate_to_staging_pose": False}, 903, "from the staging pose"),
        (
            {"use_dock_id": False, "dock_pose": stamped(2.0, 3.0), "dock_type": "home_type"}, 904,
            "is not seen: it was looked for by a flat face",
        ),
    ],
)  # fmt: skip
async def test_a_goal_that_fails_has_the_code_of_nav2_and_the_reason(
    driven: Charged, navigator: StillClient, args: Json, code: int, reason: str
) -> None:
    ended = driven.result(navigator, goal("dock_robot", "DockRobot", **args), 120.0)
    assert (ended["status"], ended["values"]["success"], ended["values"]["error_code"]) == (6, False, code)
    assert reason in ended["values"]["error_msg"]


async def test_contact_is_not_charge(driven: Charged, navigator: StillClient) -> None:
    driven.current = -0.9
    ended = driven.result(navigator, goal("dock_robot", "DockRobot", dock_id="home"), 240.0)
    assert (ended["status"], ended["values"]["error_code"], ended["values"]["num_retries"]) == (6, 906, 3)
    assert "its battery is not charged (-0.90 A)" in ended["values"]["error_msg"]
    assert driven.driving.world.pose.distance_to(DOCKED) > 0.6, "it is not left there"


async def test_a_goal_is_cancelled_and_replaced(driven: Charged, navigator: StillClient) -> None:
    navigator.say(op="send_action_goal", feedback=True, **goal("dock_robot", "DockRobot", dock_id="home"))
    driven.run(3.0)
    navigator.say(op="call_service", service="/dock_robot/_action/cancel_goal", id="c", args={})
    assert driven.next_result(navigator, 2.0)["status"] == 5
    driven.run(0.3)
    assert driven.driving.command.linear.x == 0.0
    navigator.say(op="send_action_goal", feedback=True, **goal("dock_robot", "DockRobot", dock_id="home"))
    driven.run(3.0)
    navigator.say(op="publish", topic="/goal_pose", msg=stamped(1.5, 2.0))
    assert driven.next_result(navigator, 2.0)["status"] == 5
    driven.driving.run(60.0)
    assert driven.driving.world.pose.distance_to(Pose2D(1.5, 2.0)) < 0.3


async def test_undocking_needs_to_know_the_dock_and_its_time(driven: Charged, navigator: StillClient) -> None:
    ended = driven.result(navigator, goal("undock_robot", "UndockRobot", dock_type="rocket"))
    assert (ended["status"], ended["values"]["error_code"]) == (6, 902)
    ended = driven.result(navigator, goal("undock_robot", "UndockRobot", max_undocking_time=1.0))
    assert (ended["status"], ended["values"]["error_code"]) == (6, 907)
    assert "after its time" in ended["values"]["error_msg"]
