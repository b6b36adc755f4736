"""What has happened to a vehicle, by its messages."""

import math

import pytest

from ppaas.errors import Conflict
from robots.bridges.mavlink.dialect import mavlink
from robots.bridges.mavlink.vehicle import ArmedChanged, ModeChanged, Restarted, Text, Vehicle


def heartbeat(mode: int, *, armed: bool = False) -> object:
    base = mavlink.MAV_MODE_FLAG_SAFETY_ARMED if armed else 0
    return mavlink.MAVLink_heartbeat_message(10, 3, 1 | base, mode, 4, 3)


def attitude(boot_ms: int) -> object:
    return mavlink.MAVLink_attitude_message(boot_ms, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0)


@pytest.fixture
def vehicle() -> Vehicle:
    return Vehicle(1, 1, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA)


def test_modes_and_arming_are_events_from_the_second_heartbeat_on(vehicle: Vehicle) -> None:
    assert vehicle.mode_name == "no mode yet"
    assert vehicle.take(heartbeat(0), 0.0) == []
    assert vehicle.take(heartbeat(4), 1.0) == [ModeChanged(0, 4)]
    assert vehicle.take(heartbeat(15, armed=True), 2.0) == [ModeChanged(4, 15), ArmedChanged(True)]
    assert (vehicle.mode_name, vehicle.heard_at) == ("GUIDED", 2.0)
    assert vehicle.take(heartbeat(99), 3.0) == [ModeChanged(15, 99), ArmedChanged(False)]
    assert vehicle.mode_name == "mode 99"


def test_px4_modes_have_two_numbers() -> None:
    px4 = Vehicle(1, 1, mavlink.MAV_AUTOPILOT_PX4)
    for main, sub, name in ((6, 0, "OFFBOARD"), (4, 4, "AUTO.MISSION"), (4, 3, "AUTO.LOITER"), (1, 0, "MANUAL")):
        px4.take(heartbeat(main << 16 | sub << 24), 0.0)
        assert px4.mode_name == name


def test_a_clock_that_goes_back_is_a_restart_and_a_late_message_is_none(vehicle: Vehicle) -> None:
    assert vehicle.take(attitude(60_000), 0.0) == []
    assert vehicle.take(attitude(59_000), 0.1) == []
    assert vehicle.yaw is not None
    vehicle.take(mavlink.MAVLink_gps_raw_int_message(0, 6, 0, 0, 0, 0, 0, 0, 0, 9), 0.1)
    assert vehicle.take(mavlink.MAVLink_system_time_message(0, 300), 0.2) == [Restarted()]
    assert vehicle.yaw is None and vehicle.fix == -1
    assert vehicle.take(attitude(400), 0.3) == []


def test_a_clock_of_32_bits_begins_again_after_49_days_without_a_restart(vehicle: Vehicle) -> None:
    vehicle.take(attitude(2**32 - 100), 0.0)
    assert vehicle.take(attitude(50), 0.15) == []
    assert vehicle.take(attitude(150), 0.25) == []


def test_texts_have_no_characters_that_a_terminal_would_execute(vehicle: Vehicle) -> None:
    [said] = vehicle.take(mavlink.MAVLink_statustext_message(4, b"\x1b[2Jall\nclear\xff", 0, 0), 0.0)
    assert isinstance(said, Text) and said.text.isprintable() and "all?clear" in said.text


def test_texts_of_several_parts_are_joined_and_one_with_a_lost_part_is_left_out(vehicle: Vehicle) -> None:
    def said(text: bytes, number: int = 0, part: int = 0) -> list[object]:
        return list(vehicle.take(mavlink.MAVLink_statustext_message(2, text, number, part), 0.0))

    assert said(b"PreArm: no GPS") == [Text(2, "PreArm: no GPS")]
    assert said(b"a" * 50, 7, 0) == []
    assert said(b"bc", 7, 1) == [Text(2, "a" * 50 + "bc")]
    assert said(b"a" * 50, 8, 0) == []
    assert said(b"c", 8, 2) == []
    assert said(b"c", 9, 1) == []
    for part in range(3):
        assert said(b"d" * 50, 10, part) == []
    assert said(b"d" * 50, 10, 3) == [Text(2, "d" * 200)], "it is cut"


def test_the_charge_is_the_first_batterys_or_the_systems(vehicle: Vehicle) -> None:
    vehicle.take(mavlink.MAVLink_sys_status_message(0, 0, 0, 0, 12400, 250, 76, 0, 0, 0, 0, 0, 0), 0.0)
    assert vehicle.charge is not None
    assert (vehicle.charge.voltage, vehicle.charge.current, vehicle.charge.share) == pytest.approx((12.4, 2.5, 0.76))
    cells = [4000, 4100, *[0xFFFF] * 8]
    vehicle.take(mavlink.MAVLink_battery_status_message(0, 0, 0, 0, cells, -1, 0, 0, -1), 0.0)
    assert vehicle.charge.voltage == pytest.approx(8.1)
    assert math.isnan(vehicle.charge.current) and math.isnan(vehicle.charge.share)
    before = vehicle.charge
    vehicle.take(mavlink.MAVLink_battery_status_message(1, 0, 0, 0, cells, 100, 0, 0, 10), 0.0)
    vehicle.take(mavlink.MAVLink_sys_status_message(0, 0, 0, 0, 0xFFFF, -1, -1, 0, 0, 0, 0, 0, 0), 0.0)
    assert vehicle.charge is before


def test_another_autopilot_is_refused_by_name() -> None:
    with pytest.raises(Conflict, match="GENERIC"):
        Vehicle(1, 1, mavlink.MAV_AUTOPILOT_GENERIC)
    with pytest.raises(Conflict, match="is 200"):
        Vehicle(1, 1, 200)
