"""The simulated rover: on the Earth as the anchor of a map has it, and as careful as a real one."""

import math
from typing import Any

import pytest

from ppaas.maps.georeference import GeoAnchor
from robots.bridges.mavlink.dialect import Parser, mavlink
from robots.bridges.mavlink.velocity import VELOCITY_ALONE, VELOCITY_AND_RATE
from robots.sim.mavlink.body import RoverBody
from robots.sim.mavlink.rover import OFFBOARD_STREAM, STATION_TIMEOUT, Make, SimulatedRover

STEP = 0.02


def from_station(message: Any) -> Any:
    """Return a message as station 255 sends it."""
    (found,) = Parser(1).read(Parser(255).write(message))
    return found


def run(rover: SimulatedRover, seconds: float) -> list[Any]:
    """Let a time pass; return what the rover said."""
    said = []
    for _ in range(round(seconds / STEP)):
        rover.step(STEP)
        said += rover.take_sent()
    return said


def answer(rover: SimulatedRover, command: int, *parameters: float) -> int:
    """Return the result of a command."""
    given = (*parameters, *(0.0,) * (7 - len(parameters)))
    rover.take(from_station(mavlink.MAVLink_command_long_message(1, 1, command, 0, *given)))
    return next(each.result for each in run(rover, STEP) if each.get_type() == "COMMAND_ACK")


def drive(rover: SimulatedRover, seconds: float, mask: int = VELOCITY_AND_RATE) -> None:
    for _ in range(round(seconds / 0.1)):
        numbers = 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        setpoint = mavlink.MAVLink_set_position_target_local_ned_message(0, 1, 1, 8, mask, 0.0, 0.0, 0.0, *numbers)
        rover.take(from_station(setpoint))
        run(rover, 0.1)


@pytest.mark.parametrize("latitude", [-60.0, 0.0, 47.4])
def test_the_body_drives_metres_on_the_ellipsoid(latitude: float) -> None:
    body, anchor = RoverBody(latitude, 8.5, math.radians(60.0), top_speed=50.0), GeoAnchor(latitude, 8.5)
    for _ in range(1000):
        body.drive(50.0, 0.0, 0.02)
    x, y = anchor.to_map(*body.place())
    assert (x, y) == pytest.approx((body.east, body.north), abs=0.05) and body.east > 100.0
    north, east = body.offset_of(latitude, 8.5)
    assert (north, east) == pytest.approx((-body.north, -body.east), abs=1e-6)


def test_it_says_nothing_but_heartbeats_until_it_is_asked() -> None:
    rover = SimulatedRover("ardupilot", RoverBody(47.0, 8.0))
    assert {message.get_type() for message in run(rover, 3.0)} == {"HEARTBEAT"}
    assert answer(rover, mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, mavlink.MAVLINK_MSG_ID_ATTITUDE, 100_000) == 0
    assert 9 <= sum(message.get_type() == "ATTITUDE" for message in run(rover, 1.0)) <= 11


def test_px4_enters_offboard_only_with_a_stream_and_leaves_it_without() -> None:
    rover = SimulatedRover("px4", RoverBody(47.0, 8.0))
    rover.order("arm")
    offboard = (1.0, 6.0, 0.0)
    assert answer(rover, mavlink.MAV_CMD_DO_SET_MODE, *offboard) == mavlink.MAV_RESULT_TEMPORARILY_REJECTED
    drive(rover, OFFBOARD_STREAM + 0.2, VELOCITY_ALONE)
    assert answer(rover, mavlink.MAV_CMD_DO_SET_MODE, *offboard) == mavlink.MAV_RESULT_ACCEPTED
    drive(rover, 1.0, VELOCITY_ALONE)
    assert rover.body.speed > 0.4
    said = run(rover, 2.0)
    assert rover.mode.name == "LOITER"
    assert any(getattr(message, "text", "") == "Offboard control lost" for message in said)


@pytest.mark.parametrize("make", ["ardupilot", "px4"])
def test_a_mission_needs_items_and_an_unknown_mode_is_refused(make: Make) -> None:
    rover = SimulatedRover(make, RoverBody(47.0, 8.0))
    assert answer(rover, mavlink.MAV_CMD_DO_SET_MODE, 1.0, *rover.modes.mission.command) == mavlink.MAV_RESULT_FAILED
    assert answer(rover, mavlink.MAV_CMD_DO_SET_MODE, 1.0, 99.0, 9.0) == mavlink.MAV_RESULT_UNSUPPORTED
    assert answer(rover, mavlink.MAV_CMD_DO_MOTOR_TEST) == mavlink.MAV_RESULT_UNSUPPORTED


def test_ardupilot_stands_when_its_station_is_silent() -> None:
    rover = SimulatedRover("ardupilot", RoverBody(47.0, 8.0))
    rover.order("arm")
    rover.order("mode GUIDED")
    rover.take(from_station(mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_GCS, 8, 0, 0, 4, 3)))
    drive(rover, STATION_TIMEOUT - 0.5)
    assert rover.mode.name == "GUIDED" and rover.body.speed > 0.4
    drive(rover, 2.0)
    assert rover.mode.name == "HOLD" and rover.body.speed < 0.01


def test_orders_that_it_does_not_know_are_refused() -> None:
    rover = SimulatedRover("ardupilot", RoverBody(47.0, 8.0))
    with pytest.raises(ValueError, match="fly"):
        rover.order("fly")
    with pytest.raises(ValueError, match=r"no mode 'FLYING'; it has .*GUIDED"):
        rover.order("mode FLYING")
