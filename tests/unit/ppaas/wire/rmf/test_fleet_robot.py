"""A robot that follows paths of Open-RMF, without a robot and without RMF."""

import math
from typing import Any

import pytest

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.wire.rmf.fleet_robot import DriveThrough, EndDrive, FleetRobot, RmfMode, RobotCommand
from ppaas.wire.rmf.level_frame import LevelFrame
from ppaas.wire.rmf.requests import MOST_WAYPOINTS, FollowPath, SetMode, destination_request, mode_request, path_request

STAMP = {"sec": 100, "nanosec": 5}


def location(x: float, y: float, yaw: float = 0.0, at: float = 0.0, level: str = "L1", **more: Any) -> dict[str, Any]:
    place = {"t": {"sec": int(at), "nanosec": 0}, "x": x, "y": y, "yaw": yaw, "level_name": level, "index": 0}
    return place | {"obey_approach_speed_limit": False, "approach_speed_limit": 0.0} | more


def follow(*path: dict[str, Any], task: str = "1") -> FollowPath:
    return path_request({"fleet_name": "f", "robot_name": "r", "path": list(path), "task_id": task})


def robot(frame: LevelFrame | None = None) -> FleetRobot:
    made = FleetRobot("r", "turtlebot2", "L1", frame or LevelFrame())
    made.pose = Pose2D(0.0, 0.0, 0.0)
    return made


def state(of: FleetRobot) -> dict[str, Any]:
    found = of.state(STAMP)
    assert found is not None
    return found


def remaining(of: FleetRobot) -> list[tuple[float, float]]:
    return [(place["x"], place["y"]) for place in state(of)["path"]]


def drive_of(commands: list[RobotCommand]) -> DriveThrough:
    [drive] = commands
    assert isinstance(drive, DriveThrough)
    return drive


def test_a_path_is_one_drive_whose_progress_the_states_report() -> None:
    one = robot()
    assert one.take(follow(location(0.0, 0.0), location(3.0, 0.0), location(3.0, 4.0, 1.5)), 0.0) == ""
    drive = drive_of(one.take_commands())
    assert drive.poses == (Pose2D(3.0, 0.0), Pose2D(3.0, 4.0, 1.5)), "it stands at the first"
    assert (state(one)["task_id"], state(one)["mode"]["mode"]) == ("1", RmfMode.MOVING)
    assert remaining(one) == [(3.0, 0.0), (3.0, 4.0)]
    one.drive_passed(drive.number, 2)
    assert remaining(one) == [(3.0, 0.0), (3.0, 4.0)]
    one.drive_passed(drive.number, 1)
    assert remaining(one) == [(3.0, 4.0)]
    one.drive_passed(drive.number, 2)
    assert remaining(one) == [(3.0, 4.0)], "it does not go back"
    one.drive_ended(drive.number, 1.0, reached=True)
    assert (remaining(one), state(one)["mode"]["mode"], one.take_commands()) == ([], RmfMode.IDLE, [])


def test_states_are_numbered_and_in_the_frame_of_rmf() -> None:
    one = robot(LevelFrame(scale=2.0, rotation=math.pi / 2, x=10.0, y=20.0))
    one.pose, one.battery = Pose2D(1.0, 0.0, 0.25), 42.0
    first, second = state(one), state(one)
    assert (first["seq"], second["seq"]) == (1, 2)
    assert (first["name"], first["model"], first["battery_percent"]) == ("r", "turtlebot2", 42.0)
    place = first["location"]
    assert (place["x"], place["y"], place["yaw"]) == pytest.approx((10.0, 22.0, 0.25 + math.pi / 2))
    assert (place["level_name"], place["t"]) == ("L1", STAMP)
    one.take(follow(location(10.0, 28.0, math.pi / 2)), 0.0)
    [goal] = drive_of(one.take_commands()).poses
    assert goal == pytest.approx((4.0, 0.0, 0.0))
    assert remaining(one) == [(10.0, 28.0)], "as RMF has sent it"


def test_a_robot_waits_where_the_path_repeats_a_place() -> None:
    one = robot()
    path = (location(2.0, 0.0, at=5.0), location(2.0, 0.0, at=30.0), location(4.0, 0.0, at=40.0))
    one.take(follow(*path), 0.0)
    first = drive_of(one.take_commands())
    assert first.poses == (Pose2D(2.0, 0.0),)
    one.pose = Pose2D(2.0, 0.0)
    one.drive_ended(first.number, 10.0, reached=True)
    assert (one.take_commands(), state(one)["mode"]["mode"]) == ([], RmfMode.WAITING)
    assert remaining(one) == [(2.0, 0.0), (4.0, 0.0)]
    one.advance(29.9)
    assert not one.take_commands()
    one.advance(30.0)
    assert drive_of(one.take_commands()).poses == (Pose2D(4.0, 0.0),)
    assert remaining(one) == [(4.0, 0.0)]


def test_a_wait_of_another_clock_is_left_out() -> None:
    one = robot()
    one.take(follow(location(0.0, 0.0, at=5e8), location(0.0, 0.0, at=6e8), location(4.0, 0.0, at=7e8)), 10.0)
    assert drive_of(one.take_commands()).poses == (Pose2D(4.0, 0.0),)


def test_turns_at_a_place_are_one_pose() -> None:
    one = robot()
    turns = (
        location(2.0, 0.0),
        location(2.0, 0.0, 1.5, at=1.0),
        location(2.0, 3.0, 1.5),
        location(2.0, 3.0, 3.0, at=9.0),
    )
    one.take(follow(*turns), 0.0)
    drive = drive_of(one.take_commands())
    assert drive.poses == (Pose2D(2.0, 0.0, 1.5), Pose2D(2.0, 3.0, 3.0))
    one.drive_passed(drive.number, 1)
    assert remaining(one) == [(2.0, 3.0), (2.0, 3.0)]


def test_the_lowest_speed_limit_of_a_drive_counts() -> None:
    limited = {"obey_approach_speed_limit": True, "approach_speed_limit": 0.6}
    one = robot(LevelFrame(scale=2.0))
    one.take(follow(location(2.0, 0.0, **limited), location(4.0, 0.0)), 0.0)
    assert drive_of(one.take_commands()).speed == 0.3


def test_a_repeated_request_changes_nothing_and_another_one_replaces_the_path() -> None:
    one = robot()
    request = follow(location(5.0, 0.0))
    one.take(request, 0.0)
    first = drive_of(one.take_commands())
    one.take(follow(location(5.0, 0.0)), 1.0)
    assert not one.take_commands()
    one.take(follow(location(0.0, 5.0), task="2"), 2.0)
    stop, second = one.take_commands()
    assert (stop, state(one)["task_id"]) == (EndDrive(), "2")
    one.drive_ended(first.number, 3.0, reached=False, text="cancelled")
    assert state(one)["mode"]["mode"] == RmfMode.MOVING, "the end of a drive that was replaced"
    assert isinstance(second, DriveThrough)
    one.drive_ended(second.number, 4.0, reached=True)
    assert remaining(one) == []


def test_a_path_that_fails_is_reported_until_the_next_request() -> None:
    one = robot()
    one.take(follow(location(5.0, 0.0)), 0.0)
    one.drive_ended(drive_of(one.take_commands()).number, 1.0, reached=False, text="a keep-out zone")
    assert (state(one)["mode"]["mode"], one.error) == (RmfMode.ADAPTER_ERROR, "a keep-out zone")
    assert remaining(one) == [(5.0, 0.0)]
    one.advance(2.0)
    assert not one.take_commands()
    one.take(follow(location(0.0, 5.0), task="2"), 3.0)
    assert drive_of(one.take_commands()).poses == (Pose2D(0.0, 5.0),)
    assert (state(one)["mode"]["mode"], one.error) == (RmfMode.MOVING, "")


def test_a_drive_that_was_lost_begins_again() -> None:
    one = robot()
    one.take(follow(location(5.0, 0.0)), 0.0)
    assert drive_of(one.take_commands()).number
    one.drive_lost()
    one.pose = None
    one.advance(2.0)
    assert (one.take_commands(), one.state(STAMP)) == ([], None), "a robot without a pose has no state"
    one.pose = Pose2D(1.0, 0.0)
    one.advance(3.0)
    assert drive_of(one.take_commands()).poses == (Pose2D(5.0, 0.0),)


def test_a_path_on_another_level_is_an_error() -> None:
    one = robot()
    one.take(follow(location(5.0, 0.0, level=""), location(5.0, 5.0, level="L2")), 0.0)
    assert (state(one)["mode"]["mode"], one.take_commands()) == (RmfMode.ADAPTER_ERROR, [])
    assert "'L2'" in one.error


def test_a_pause_holds_the_path() -> None:
    one = robot()
    one.take(follow(location(5.0, 0.0)), 0.0)
    one.take_commands()
    one.take(SetMode("p", RmfMode.PAUSED), 1.0)
    assert (one.take_commands(), state(one)["mode"]["mode"], state(one)["task_id"]) == (
        [EndDrive()],
        RmfMode.PAUSED,
        "p",
    )
    one.advance(2.0)
    assert not one.take_commands()
    assert remaining(one) == [(5.0, 0.0)]
    one.take(SetMode("q", RmfMode.MOVING), 3.0)
    assert drive_of(one.take_commands()).poses == (Pose2D(5.0, 0.0),)


def test_modes_that_the_robot_does_not_have_are_refused_and_not_confirmed() -> None:
    one = robot()
    dock = mode_request({"task_id": "d", "mode": {"mode": 7}, "parameters": [{"name": "docking", "value": "dock"}]})
    assert "mode 7 is not supported" in one.take(dock, 0.0)
    assert (state(one)["task_id"], state(one)["mode"]["mode"]) == ("", RmfMode.IDLE)


def test_an_empty_path_stops_the_robot() -> None:
    one = robot()
    one.take(follow(location(5.0, 0.0)), 0.0)
    one.take_commands()
    one.take(follow(task="2"), 1.0)
    assert (one.take_commands(), remaining(one), state(one)["mode"]["mode"]) == ([EndDrive()], [], RmfMode.IDLE)


def test_a_destination_is_a_path_of_one_place() -> None:
    one = robot()
    one.take(destination_request({"destination": location(3.0, 1.0, 0.5), "task_id": "9"}), 0.0)
    assert drive_of(one.take_commands()).poses == (Pose2D(3.0, 1.0, 0.5),)
    one.charging = True
    assert state(one)["task_id"] == "9"


def test_a_robot_at_its_charger_is_charging_while_it_has_no_path() -> None:
    one = robot()
    one.charging = True
    assert state(one)["mode"]["mode"] == RmfMode.CHARGING
    one.take(follow(location(0.05, 0.0)), 0.0)
    assert (one.take_commands(), remaining(one)) == ([], []), "it is there"
    one.take(follow(location(0.05, 0.0, 2.0), task="2"), 0.0)
    assert drive_of(one.take_commands()).poses == (Pose2D(0.05, 0.0, 2.0),), "but for its heading"


@pytest.mark.parametrize("x", [math.nan, math.inf, None, 1e12])
def test_waypoints_that_are_nowhere_are_refused(x: float | None) -> None:
    with pytest.raises(InvalidInput, match="is nowhere"):
        follow(location(0.0, 0.0), location(x, 0.0))  # type: ignore[arg-type]


def test_paths_are_of_limited_length() -> None:
    with pytest.raises(InvalidInput, match="at most"):
        follow(*[location(0.0, 0.0)] * (MOST_WAYPOINTS + 1))
