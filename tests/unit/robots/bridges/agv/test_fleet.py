"""Fleet of AGVs: which are taken, as which robots, and what is sent to them."""

import asyncio
from types import SimpleNamespace

import pytest

from ppaas.clock import ManualClock
from ppaas.geometry import Pose2D
from ppaas.wire.vda5050 import topics
from ppaas.wire.vda5050.headers import MessageHeader
from ppaas.wire.vda5050.states import Connection
from ppaas.wire.vda5050.topics import AgvAddress, Version
from robots.bridges.agv import agv_robot
from robots.bridges.agv.agv_robot import LEAVE_AFTER
from robots.bridges.agv.agv_side import AgvSide
from robots.bridges.agv.fleet import filters
from robots.bridges.agv.options import FleetOptions
from robots.bridges.agv.registration import CORES, robot_file
from robots.bridges.vda5050.mqtt_link import Outbox
from storage.names import is_name
from tests.support.vda5050.fleet import FleetWithAgv
from tests.support.vda5050.led_agv import path
from tests.support.vda5050.messages import FACTSHEET
from tests.support.waiting import until

ONLINE = Connection(connection_state="ONLINE")


def address(serial: str, manufacturer: str = "acme") -> AgvAddress:
    return AgvAddress.of(Version.V2_1, manufacturer, serial)


def header(number: int = 0, version: str = "2.1.0", serial: str = "7", manufacturer: str = "acme") -> MessageHeader:
    return MessageHeader(
        header_id=number, timestamp="2026-01-31T11:40:03.123Z", version=version,
        manufacturer=manufacturer, serial_number=serial,
    )  # fmt: skip


def test_agvs_are_robots_by_their_serial_numbers_except_robots_of_the_cloud():
    options = FleetOptions()
    assert options.robots_of(address("fork 7.b"))[0] == "fork_7_b"
    assert options.robots_of(address("tb1", "ppaas")) == ()


def test_agvs_that_differ_in_maker_or_in_characters_that_ids_lack_have_ids_of_their_own():
    options = FleetOptions()
    agvs = [address("1234", "alpha"), address("1234", "beta"), address("12.34", "alpha"), address("12 34", "alpha")]
    names = [options.robots_of(agv) for agv in agvs]
    assert names[0][:2] == ("1234", "alpha_1234")
    assert len({each[-1] for each in names}) == len(agvs)
    long = [options.robots_of(address(f"{'9' * 199}{digit}", "m" * 200)) for digit in "12"]
    assert long[0][-1] != long[1][-1]
    assert all(is_name(name) for each in (*names, *long) for name in each)
    assert options.robots_of(address("_-7"))[0] == "7"
    assert options.robots_of(address("é"))[0] == "agv"


def test_listed_agvs_are_taken_alone():
    options = FleetOptions(robots={"ppaas/tb1": "mirror"})
    assert options.robots_of(address("tb1", "ppaas")) == ("mirror",)
    assert options.robots_of(address("fork")) == ()


def test_topics_of_both_major_versions_are_subscribed_to():
    assert "uagv/v2/+/+/state" in filters("")
    assert "vda5050/v3/+/+/connection" in filters("")
    assert "hall/v3/+/+/factsheet" in filters("hall")


def test_the_file_of_a_robot_has_the_size_of_the_factsheet():
    file = robot_file(address("7"), "office", FACTSHEET, None)
    body = FACTSHEET.physical_parameters
    assert body is not None
    expected = 0.5 * (body.length**2 + body.width**2) ** 0.5
    assert file.parameters == {"follow_path": {}, "global_costmap": {"robot_radius": pytest.approx(expected)}}
    assert (file.map, file.cores) == ("office", CORES)
    assert robot_file(address("7"), "office", None, None).parameters == {"follow_path": {}}


def why(side: AgvSide, topic: str, one: MessageHeader) -> str:
    left_out = side.left_out(topic, one)
    return "" if left_out is None else left_out.reason


def test_messages_count_once_in_order_and_by_their_own_agv():
    side = AgvSide(address("7"), Outbox())
    assert why(side, topics.STATE, header(1)) == ""
    assert why(side, topics.STATE, header(1)) == "repeated message 1 on state"
    assert why(side, topics.STATE, header(0)) == "late message 0 on state"
    assert why(side, topics.STATE, header(2, serial="8")) == "the header of state names AGV 'acme/8'"
    assert why(side, topics.VISUALIZATION, header(0, serial="", manufacturer="")) == ""
    assert why(side, topics.CONNECTION, header(9)) == why(side, topics.CONNECTION, header(0)) == ""


def test_ids_of_all_topics_begin_again_with_those_of_the_connection():
    side = AgvSide(address("7"), Outbox())
    side.left_out(topics.CONNECTION, header(3))
    side.left_out(topics.STATE, header(5000))
    side.left_out(topics.CONNECTION, header(3))
    assert why(side, topics.STATE, header(0)) != "", "the broker sends a retained message again"
    side.left_out(topics.CONNECTION, header(0))
    assert why(side, topics.STATE, header(0)) == ""


def test_an_agv_is_spoken_to_in_its_own_version():
    side = AgvSide(address("7"), Outbox())
    assert side.version is Version.V2_1
    side.left_out(topics.STATE, header(0, version="2.0.0"))
    assert side.version is Version.V2_0
    side.left_out(topics.STATE, header(1, version="3.0.0"))
    assert side.version is Version.V2_0, "a major version is that of the topic"


@pytest.mark.parametrize("version", Version)
async def test_an_agv_of_each_version_drives_its_path(version):
    tested = FleetWithAgv(version)
    tested.say(topics.CONNECTION, ONLINE)
    tested.say(topics.STATE, tested.agv.state())
    await tested.obey()
    assert [action.action_type for action in tested.agv.actions] == ["stateRequest", "factsheetRequest"]
    tested.robot._follow(path("a", (0.0, 0.0), (3.0, 0.0)))
    for _ in range(6):
        await tested.obey()
        tested.agv.drive(1.0)
        tested.say(topics.STATE, tested.agv.state())
    assert tested.agv.pose.x == 3.0
    assert tested.robot._control.path == ""


def test_an_invalid_message_is_logged_once(caplog):
    tested = FleetWithAgv()
    for _ in range(10):
        tested.fleet.receive(tested.address.topic(topics.STATE), b"{}", False)
    assert caplog.text.count("a message is left out") == 1
    tested.fleet.receive("uagv/v2/state", b"{}", False)
    tested.fleet.receive(tested.address.topic("unknown"), b"{}", False)
    assert tested.robot._control.state is None


async def test_a_fault_in_one_agv_concerns_no_other_and_is_logged_once(caplog, monkeypatch):
    monkeypatch.setattr("robots.bridges.agv.fleet.TICK", 0.0)
    tested, ticks = FleetWithAgv(), []
    faulty, other = AgvAddress.of(Version.V2_1, "acme", "0"), tested.robot

    def fail(*_, **__):
        raise ZeroDivisionError

    broken = SimpleNamespace(tick=fail, take=fail, broker_lost=fail, refuse=lambda *_: None)
    tested.fleet.robots = {faulty: broken, tested.address: other}
    monkeypatch.setattr(other, "tick", lambda: ticks.append(1))
    ticking = asyncio.create_task(tested.fleet._tick())
    await until(lambda: len(ticks) >= 3)
    ticking.cancel()
    for _ in range(3):
        payload = tested.say(topics.CONNECTION, ONLINE)
        tested.fleet.receive(faulty.topic(topics.CONNECTION), payload, False)
    tested.fleet._broker_lost()
    assert other._control.connection == "CONNECTION_BROKEN"
    assert [record.getMessage() for record in caplog.records if record.levelname == "ERROR"] == [
        "AGV acme/0 failed; the other listeners go on"
    ]


async def test_a_new_agv_is_found_by_its_first_message():
    tested = FleetWithAgv()
    tested.fleet.robots.clear()
    async with asyncio.TaskGroup() as group:
        tested.fleet._group = group
        tested.say(topics.CONNECTION, ONLINE)
        (robot,) = tested.fleet.robots.values()
        assert robot._control.connection == "ONLINE"
        group.create_task(_cancel_others())


async def _cancel_others() -> None:
    for task in asyncio.all_tasks():
        if task.get_coro().__qualname__ == "AgvRobot.run":
            task.cancel()


def test_a_lost_broker_is_a_broken_connection():
    tested = FleetWithAgv()
    tested.say(topics.CONNECTION, ONLINE)
    tested.say(topics.STATE, tested.agv.state())
    assert tested.robot._why_unusable() == ""
    tested.fleet._broker_lost()
    assert tested.robot._why_unusable() == "the AGV is CONNECTION_BROKEN"


def test_initial_poses_and_instant_actions_reach_the_agv():
    tested = FleetWithAgv()
    tested.say(topics.CONNECTION, ONLINE)
    tested.say(topics.STATE, tested.agv.state())
    tested.robot._initial_pose(Pose2D(1.0, 2.0, 0.5))
    tested.robot._action("startPause")
    asyncio.run(tested.obey())
    assert tested.agv.pose == Pose2D(1.0, 2.0, 0.5)
    assert tested.agv.paused


# -- presence ----------------------------------------------------------------------------------------------------------


def there(tested: FleetWithAgv) -> bool:
    """Return whether the AGV is to be its robot in the cloud."""
    return tested.robot._there.is_set() and not tested.robot._left.is_set()


@pytest.mark.parametrize("away", ["OFFLINE", "HIBERNATING"])
async def test_the_robot_of_an_agv_that_goes_offline_leaves_at_once_and_comes_back_with_it(away: str) -> None:
    tested = FleetWithAgv(Version.V3_0)
    tested.say(topics.CONNECTION, ONLINE)
    assert not there(tested)
    tested.say(topics.STATE, tested.agv.state())
    assert there(tested)
    tested.say(topics.CONNECTION, Connection(connection_state=away))  # type: ignore[arg-type]
    assert not there(tested)
    assert tested.robot._left.is_set()
    tested.robot._left.clear()  # the robot has left
    assert not there(tested)
    tested.say(topics.CONNECTION, ONLINE)
    assert there(tested)


async def test_the_robot_of_an_agv_whose_connection_is_broken_leaves_after_a_moment(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    clock = ManualClock(1000.0)
    monkeypatch.setattr(agv_robot, "monotonic", clock)
    tested = FleetWithAgv()
    tested.say(topics.CONNECTION, ONLINE)
    tested.say(topics.STATE, tested.agv.state())
    tested.say(topics.CONNECTION, Connection(connection_state="CONNECTION_BROKEN"))
    clock.advance(LEAVE_AFTER)
    tested.robot.tick()
    assert there(tested)
    clock.advance(0.1)
    tested.robot.tick()
    assert not there(tested)


async def test_all_robots_leave_after_a_moment_without_the_broker(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = ManualClock(1000.0)
    monkeypatch.setattr(agv_robot, "monotonic", clock)
    tested = FleetWithAgv()
    tested.say(topics.CONNECTION, ONLINE)
    tested.say(topics.STATE, tested.agv.state())
    tested.fleet._broker_lost()
    clock.advance(LEAVE_AFTER + 0.1)
    tested.robot.tick()
    assert not there(tested)
