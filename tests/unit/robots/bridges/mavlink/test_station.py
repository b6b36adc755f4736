"""A station finds its vehicle, keeps to it, and takes signed messages alone if it has a key."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from ppaas.errors import Conflict, InvalidInput
from robots.bridges.mavlink.dialect import Parser, mavlink
from robots.bridges.mavlink.link import VehicleAddress
from robots.bridges.mavlink.station import SEARCH, Finder, GroundStation, StationOptions, key_of

HERE, THERE = ("127.0.0.1", 1), ("127.0.0.1", 2)
KEY, OTHER_KEY = b"k" * 32, b"o" * 32


def heartbeat(autopilot: int = 3, kind: int = 10) -> Any:
    return mavlink.MAVLink_heartbeat_message(kind, autopilot, 1, 4, 4, 3)


def parser(system: int, key: bytes | None = None) -> Parser:
    made = Parser(system, key)
    made.srcComponent = 1
    return made


def read(message: Any, system: int) -> Any:
    """Return a message as one of a system."""
    (found,) = Parser(255).read(parser(system).write(message))
    return found


@pytest.fixture
def made() -> Callable[..., tuple[GroundStation, list[str]]]:
    def make(**options: Any) -> tuple[GroundStation, list[str]]:
        taken: list[str] = []
        options = {"address": VehicleAddress.parse("udpin:127.0.0.1:1"), **options}
        return GroundStation(StationOptions(**options), lambda message, _: taken.append(message.get_type())), taken

    return make


def test_the_only_vehicle_is_found_after_a_while_and_a_named_one_at_once() -> None:
    finder = Finder(None)
    assert finder.choose(0.0) is None
    finder.take(read(heartbeat(), 7), 0.0)
    assert finder.choose(SEARCH - 0.1) is None
    assert finder.choose(SEARCH).get_srcSystem() == 7
    named = Finder(8)
    named.take(read(heartbeat(), 7), 0.0)
    assert named.choose(9.0) is None
    named.take(read(heartbeat(), 8), 9.0)
    assert named.choose(9.0).get_srcSystem() == 8


def test_several_vehicles_are_refused_with_their_numbers() -> None:
    finder = Finder(None)
    for system in (3, 2):
        finder.take(read(heartbeat(), system), 0.0)
    with pytest.raises(Conflict, match=r"vehicles 2, 3 .*--system"):
        finder.choose(SEARCH)


def test_stations_and_cameras_are_no_vehicles_and_aircraft_are_refused() -> None:
    finder = Finder(None)
    finder.take(read(heartbeat(8, mavlink.MAV_TYPE_GCS), 255), 0.0)
    finder.take(read(heartbeat(8, mavlink.MAV_TYPE_CAMERA), 1), 0.0)
    assert finder.choose(SEARCH + 1.0) is None
    finder.take(read(heartbeat(3, mavlink.MAV_TYPE_QUADROTOR), 1), 5.0)
    with pytest.raises(Conflict, match="QUADROTOR"):
        finder.choose(5.0 + SEARCH)


def test_messages_of_others_are_left_out_also_of_a_second_vehicle_with_the_same_number(
    made: Callable[..., tuple[GroundStation, list[str]]], caplog: pytest.LogCaptureFixture
) -> None:
    station, taken = made()
    one = parser(1)
    station.receive(one.write(heartbeat()), HERE)
    assert not taken and list(station.finder.found) == [1]
    station.choose(1)
    station.receive(one.write(heartbeat()) + one.write(mavlink.MAVLink_system_time_message(0, 5)), HERE)
    station.receive(parser(1).write(heartbeat()), THERE)
    station.receive(parser(2).write(heartbeat()), THERE)
    station.receive(b"\xfd\x00no message\xfe", THERE)
    assert taken == ["HEARTBEAT", "SYSTEM_TIME"]
    assert "another vehicle with the number 1" in caplog.text and "vehicle 2 is at this port" in caplog.text


def test_a_message_may_come_in_pieces(made: Callable[..., tuple[GroundStation, list[str]]]) -> None:
    station, taken = made(address=VehicleAddress.parse("tcp:127.0.0.1:1"))
    station.choose(1)
    data = b"noise" + parser(1).write(heartbeat())
    for start in range(0, len(data), 3):
        station.receive(data[start : start + 3], None)
    assert taken == ["HEARTBEAT"]


def test_with_a_key_unsigned_and_wrongly_signed_messages_are_left_out_and_do_no_harm(
    made: Callable[..., tuple[GroundStation, list[str]]], caplog: pytest.LogCaptureFixture
) -> None:
    station, taken = made(key=KEY)
    station.choose(1)
    good, forger = parser(1, KEY), parser(1, OTHER_KEY)
    station.receive(good.write(heartbeat()), HERE)
    station.receive(forger.write(heartbeat()), HERE)
    station.receive(parser(1).write(heartbeat()), HERE)
    again = good.write(heartbeat())
    station.receive(again, HERE)
    station.receive(again, HERE)
    assert taken == ["HEARTBEAT"] * 2
    assert station.forged == 3
    assert caplog.text.count("--signing-key-file") == 1


def test_what_is_sent_is_signed(made: Callable[..., tuple[GroundStation, list[str]]]) -> None:
    station, _ = made(key=KEY, address=VehicleAddress.parse("udpout:127.0.0.1:1"))
    sent: list[bytes] = []
    station.line.send = lambda data, to: sent.append(data)  # type: ignore[method-assign]
    station.heartbeat()
    station.heartbeat()
    reader = parser(1, KEY)
    found = [message for data in sent for message in reader.read(data)]
    assert [message.get_type() for message in found] == ["HEARTBEAT"] * 2
    assert all(message.get_signed() for message in found) and found[0].get_srcSystem() == 255


def test_a_key_is_digits_or_a_passphrase(tmp_path: Path) -> None:
    file = tmp_path / "key"
    file.write_text("0A" * 32 + "\n")
    assert key_of(file) == b"\n" * 32
    file.write_text("open sesame\n")
    assert key_of(file).hex().startswith("41ef4bb0b23661e6")
    file.write_text(" \n")
    with pytest.raises(InvalidInput, match="has no key"):
        key_of(file)
    with pytest.raises(InvalidInput, match="cannot read"):
        key_of(tmp_path)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("udpin:0.0.0.0:14550", ("udpin", "0.0.0.0", 14550)),
        ("udpout:rover:14550", ("udpout", "rover", 14550)),
        ("tcp:127.0.0.1:5760", ("tcp", "127.0.0.1", 5760)),
        ("/dev/ttyACM0", ("serial", "/dev/ttyACM0", 57600)),
        ("/dev/ttyUSB0,921600", ("serial", "/dev/ttyUSB0", 921600)),
    ],
)
def test_addresses_are_those_of_mavproxy(text: str, found: tuple[str, str, int]) -> None:
    address = VehicleAddress.parse(text)
    assert (address.kind, address.host, address.port) == found


@pytest.mark.parametrize(
    "text",
    [
        "", "udpin:14550", "udp:1.2.3.4:5", "tcp:host:99999", "/dev/tty,fast", "tcp:host:", "tcp:a..b:5760",
        f"udpout:{'a' * 64}:5760", f"tcp:host:{'9' * 5000}", f"/dev/tty,{'9' * 5000}", "/dev/tty,0",
    ],
)  # fmt: skip
def test_other_addresses_are_refused_with_examples(text: str) -> None:
    with pytest.raises(InvalidInput, match="udpin:HOST:PORT"):
        VehicleAddress.parse(text)
