"""A rover that is driven by velocities: taken for a goal, given back after it, and left to everybody else."""

import math
from typing import Any

import pytest

from robots.bridges.mavlink.authority import Hold
from robots.bridges.mavlink.dialect import Parser, mavlink
from robots.bridges.mavlink.modes import PX4, book_of
from robots.bridges.mavlink.vehicle import Vehicle
from robots.bridges.mavlink.velocity import LEAD, MOST_LEAD, SILENCE, VelocityDrive, setpoint
from robots.sim.mavlink.rover import Make
from tests.support.mavlink.closed_loop import ClosedLoop

MAKES = pytest.mark.parametrize("make", ["ardupilot", "px4"])


def looped(make: Make, **options: bool) -> ClosedLoop:
    """Return a rover that has been heard and is localized."""
    loop = ClosedLoop(make, waypoints=False, **options)
    loop.run(2.0)
    assert loop.cloud.motions
    return loop


def refusals(loop: ClosedLoop) -> str:
    """Return why the rover is not driven, as the diagnostics say."""
    loop.run(0.2)
    return loop.cloud.words[0]


@MAKES
def test_a_rover_drives_while_the_clone_wants_it_and_stands_in_its_own_mode_afterwards(make: Make) -> None:
    loop = looped(make)
    start = loop.truth
    loop.speed = 0.5
    loop.until(lambda: loop.truth.distance_to(start) > 2.0)
    assert loop.sim.mode == loop.sim.modes.velocity and loop.sim.armed
    ahead = start.inverse() @ loop.truth
    assert ahead.x > 1.9 and abs(ahead.y) < 0.05
    assert loop.cloud.motions[-1].forward == pytest.approx(0.5, abs=0.02)

    loop.speed = 0.0
    loop.run(SILENCE + 0.5)
    assert abs(loop.sim.body.speed) < 0.01
    loop.until(lambda: loop.sim.mode == loop.sim.modes.hold, 6.0)
    loop.run(0.1)
    assert isinstance(loop.drive, VelocityDrive) and loop.drive.authority.hold is Hold.NONE
    assert not loop.cloud.cancelled
    sent = len(loop.station.sent)
    loop.run(1.5)
    assert {message.get_type() for message in loop.station.sent[sent:]} == {"HEARTBEAT"}


@MAKES
def test_a_rover_turns_to_the_side_that_is_wanted(make: Make) -> None:
    loop = looped(make)
    loop.turn = 0.6
    before = loop.truth.theta
    loop.run(4.0)
    assert math.remainder(loop.truth.theta - before, math.tau) > 0.5
    assert loop.cloud.motions[-1].turn > 0.2
    assert abs(loop.sim.body.speed) < 0.01


def test_ardupilot_drives_backwards_and_px4_does_not() -> None:
    for make, least, most in (("ardupilot", -2.5, -1.0), ("px4", -0.05, 0.05)):
        loop = looped(make)  # type: ignore[arg-type]
        start = loop.truth
        loop.speed = -0.5
        loop.run(5.0)
        assert least < (start.inverse() @ loop.truth).x < most


def test_a_px4_rover_that_is_to_stand_is_not_turned_north() -> None:
    loop = looped("px4")
    loop.speed = 0.3
    loop.until(lambda: loop.sim.mode == loop.sim.modes.velocity)
    loop.run(1.0)
    heading = loop.sim.body.heading
    loop.speed = 0.0
    loop.run(1.5)
    assert loop.sim.body.heading == pytest.approx(heading, abs=0.02)


@MAKES
def test_a_rover_that_another_station_takes_is_left_alone_until_another_goal(make: Make) -> None:
    loop = looped(make)
    assert isinstance(loop.drive, VelocityDrive)
    loop.drive.goals(frozenset({"a"}))
    loop.speed = 0.5
    loop.until(lambda: loop.drive.authority.drives)  # type: ignore[union-attr]
    loop.sim.order("mode MANUAL")
    loop.until(lambda: loop.cloud.cancelled == 1, 3.0)
    assert "switched to MANUAL" in refusals(loop)
    loop.speed = 0.0
    loop.run(1.0)
    loop.speed = 0.5  # of the same goal, whose end has not arrived
    sent = len(loop.station.sent)
    loop.run(3.0)
    assert loop.sim.mode.name == "MANUAL"
    assert {message.get_type() for message in loop.station.sent[sent:]} == {"HEARTBEAT"}

    loop.speed = 0.0
    loop.drive.goals(frozenset({"b"}))
    loop.run(0.7)
    loop.speed = 0.5
    loop.until(lambda: loop.sim.mode == loop.sim.modes.velocity, 5.0)
    loop.until(lambda: loop.sim.body.speed > 0.3, 5.0)


@MAKES
def test_a_rover_that_a_person_takes_while_the_bridge_takes_it_is_the_persons(make: Make) -> None:
    loop = looped(make)
    loop.speed = 0.5
    loop.run(0.1)
    loop.sim.order("mode MANUAL")
    loop.until(lambda: loop.cloud.cancelled == 1, 2.0)
    loop.run(3.0)
    assert loop.sim.mode.name == "MANUAL"


@MAKES
def test_a_rover_that_is_disarmed_while_it_drives_is_not_armed_again(make: Make) -> None:
    loop = looped(make)
    loop.speed = 0.5
    loop.until(lambda: loop.drive.authority.drives)
    loop.sim.order("disarm")
    loop.until(lambda: loop.cloud.cancelled == 1, 3.0)
    assert "was disarmed" in refusals(loop)
    loop.run(3.0)
    assert not loop.sim.armed


def test_without_the_option_the_bridge_does_not_arm_nor_drive_when_somebody_else_arms() -> None:
    loop = looped("ardupilot", arm=False)
    loop.speed = 0.5
    loop.until(lambda: loop.cloud.cancelled == 1, 3.0)
    assert "is not armed" in refusals(loop)
    loop.sim.order("arm")
    loop.run(3.0)
    assert loop.sim.mode == loop.sim.modes.hold and loop.sim.body.speed == 0.0
    loop.speed = 0.0
    loop.run(1.0)
    loop.speed = 0.5
    loop.until(lambda: loop.sim.body.speed > 0.3, 5.0)


@MAKES
def test_a_rover_that_refuses_to_be_armed_says_why(make: Make) -> None:
    loop = looped(make)
    loop.sim.order("refuse Compass not healthy")
    loop.speed = 0.5
    loop.until(lambda: loop.cloud.cancelled == 1, 5.0)
    assert "refuses to be armed: FAILED (PreArm: Compass not healthy)" in refusals(loop)
    assert not loop.sim.armed


@MAKES
def test_a_rover_that_restarts_is_driven_by_another_goal_alone(make: Make) -> None:
    loop = looped(make)
    loop.run(3.0)
    loop.speed = 0.5
    loop.until(lambda: loop.sim.body.speed > 0.3)
    loop.sim.order("reboot")
    loop.until(lambda: loop.cloud.cancelled == 1, 15.0)
    assert any(words in refusals(loop) for words in ("restarted", "disarmed", "switched"))
    loop.speed = 0.0
    loop.run(2.0)
    loop.until(lambda: loop.cloud.problems[-1] == "", 15.0)  # what it sends was asked for again
    assert loop.cloud.motions[-1].pose.distance_to(loop.truth) < 0.1
    loop.speed = 0.5
    loop.until(lambda: loop.sim.body.speed > 0.3, 10.0)


def test_a_rover_that_is_not_heard_is_given_up() -> None:
    loop = looped("ardupilot")
    loop.speed = 0.5
    loop.until(lambda: loop.drive.authority.drives)
    loop.sim.order("mute")
    loop.until(lambda: loop.cloud.cancelled == 1, 6.0)
    assert "no heartbeat" in refusals(loop)
    assert "no heartbeat" in loop.cloud.problems[-1]


def test_velocities_that_stop_coming_stop_the_rover() -> None:
    loop = looped("ardupilot")
    loop.speed = 0.5
    loop.until(lambda: loop.sim.body.speed > 0.4)
    loop.commands = False
    loop.run(SILENCE + 0.6)
    assert abs(loop.sim.body.speed) < 0.01


@MAKES
def test_a_bridge_that_dies_leaves_the_rover_to_its_own_failsafe(make: Make) -> None:
    loop = looped(make)
    loop.speed = 0.5
    loop.until(lambda: loop.sim.body.speed > 0.4)
    loop.station.cut = True
    loop.run(7.0)
    assert abs(loop.sim.body.speed) < 0.01
    assert loop.sim.mode == loop.sim.modes.hold


@MAKES
def test_a_stopped_robot_stands_in_its_own_mode_until_the_release(make: Make) -> None:
    loop = looped(make)
    loop.speed = 0.5
    loop.until(lambda: loop.sim.body.speed > 0.4)
    loop.rover.stop(True, loop.now)
    loop.run(2.0)
    assert loop.sim.mode == loop.sim.modes.hold and abs(loop.sim.body.speed) < 0.01
    assert not loop.cloud.cancelled
    loop.rover.stop(False, loop.now)
    loop.until(lambda: loop.sim.body.speed > 0.4, 6.0)


def read_by_station(message: Any) -> Any:
    writer = Parser(1)
    writer.srcComponent = 1
    (found,) = Parser(255).read(writer.write(message))
    return found


def ring() -> Any:
    distances = [300, *[1201] * 71]
    return read_by_station(mavlink.MAVLink_obstacle_distance_message(0, 0, distances, 5, 20, 1200, 0.0, 0.0, 12))


def test_distances_are_scans_if_the_clone_expects_them_and_the_rover_knows_its_place(
    caplog: pytest.LogCaptureFixture,
) -> None:
    loop = looped("ardupilot")
    loop.rover.take(ring(), loop.now)
    assert len(loop.cloud.scans) == 1 and max(loop.cloud.scans[0].ranges) == 12.01
    loop.sim.order("fix 1")
    loop.run(3.0)
    loop.rover.take(ring(), loop.now)
    assert len(loop.cloud.scans) == 1
    without = looped("ardupilot", scans=False)
    without.rover.take(ring(), without.now)
    assert not without.cloud.scans and '"localize": false' in caplog.text


def test_answers_to_another_station_and_clocks_of_cameras_do_not_count() -> None:
    loop = looped("ardupilot")
    loop.run(3.0)
    loop.speed = 0.5
    loop.run(0.1)
    denied = mavlink.MAVLink_command_ack_message(mavlink.MAV_CMD_DO_SET_MODE, mavlink.MAV_RESULT_DENIED, 0, 0, 250, 190)
    loop.rover.take(read_by_station(denied), loop.now)
    camera = Parser(1)
    camera.srcComponent = mavlink.MAV_COMP_ID_CAMERA
    for message in (mavlink.MAVLink_system_time_message(0, 5), mavlink.MAVLink_heartbeat_message(30, 8, 0, 0, 4, 3)):
        (read,) = Parser(255).read(camera.write(message))
        loop.rover.take(read, loop.now)
    loop.until(lambda: loop.sim.body.speed > 0.3)
    assert not loop.cloud.cancelled


def test_setpoints_are_those_of_the_makes() -> None:
    ardupilot = Vehicle(3, 1, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA)
    one = setpoint(ardupilot, -0.4, 0.25, 7)
    assert (one.coordinate_frame, one.type_mask) == (mavlink.MAV_FRAME_BODY_NED, 0x5E7)  # as ArduPilot documents it
    assert (one.vx, one.vy, one.yaw_rate, one.target_system) == (-0.4, 0.0, -0.25, 3)

    px4 = Vehicle(3, 1, mavlink.MAV_AUTOPILOT_PX4)
    px4.yaw = math.pi / 2.0  # east
    east = setpoint(px4, 1.0, 0.0, 7)
    assert (east.coordinate_frame, east.type_mask) == (mavlink.MAV_FRAME_LOCAL_NED, 0xDC7)
    assert (east.vx, east.vy) == pytest.approx((0.0, 1.0), abs=1e-9)
    left = setpoint(px4, 1.0, 1.0, 7)
    assert math.atan2(left.vy, left.vx) == pytest.approx(math.pi / 2.0 - MOST_LEAD)
    spot = setpoint(px4, 0.0, -1.0, 7)
    assert math.atan2(spot.vy, spot.vx) == pytest.approx(math.pi / 2.0 + LEAD)
    assert math.hypot(spot.vx, spot.vy) < 0.01
    assert book_of(mavlink.MAV_AUTOPILOT_PX4) is PX4
