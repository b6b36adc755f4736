"""States of an AGV that are left out: it counts as not localized, the reason is known, and it gets no order."""

import asyncio
import json
from collections.abc import Callable

import msgspec
import pytest

from ppaas.geometry import Pose2D
from ppaas.messages import decode
from ppaas.messages.health.diagnostic_msgs import DiagnosticArray
from ppaas.wire.vda5050 import topics
from ppaas.wire.vda5050.states import Connection, ConnectionState
from ppaas.wire.vda5050.topics import Version
from robots.bridges.agv import agv_robot
from robots.bridges.agv.cloud_side import CloudCallbacks, CloudSide
from tests.support.vda5050.fleet import FleetWithAgv
from tests.support.vda5050.led_agv import path

HOUR = 3600.0
ELSEWHERE = Pose2D(6.5, 0.0)


class Published:
    """Stands in for the link of the robot: keeps the newest message of each topic."""

    def __init__(self) -> None:
        self.newest: dict[str, bytes] = {}

    def publish_newest(self, topic: str, payload: bytes) -> None:
        self.newest[topic] = payload

    def publish_together(self, _key: str, messages: object) -> None:
        self.newest |= dict(messages)  # type: ignore[call-overload]


def connected(version: Version = Version.V2_1) -> tuple[FleetWithAgv, Published]:
    """Return a fleet whose AGV has been running for a while, and is a robot of the cloud."""
    tested = FleetWithAgv(version)
    cloud = CloudSide("http://127.0.0.1:9", "token", "fork-7", CloudCallbacks(*[lambda *_: None] * 5))
    published = cloud.link = Published()  # type: ignore[assignment]
    tested.robot._cloud, tested.robot._map = cloud, "hall"
    online(tested, "ONLINE")
    tested.header_ids(5000)
    state(tested)
    asyncio.run(tested.obey())
    return tested, published  # type: ignore[return-value]


def online(tested: FleetWithAgv, word: ConnectionState) -> None:
    tested.say(topics.CONNECTION, Connection(connection_state=word))


def state(tested: FleetWithAgv) -> None:
    tested.say(topics.STATE, tested.agv.state())


def pose(published: Published) -> float:
    return float(json.loads(published.newest["amcl_pose"])["pose"]["pose"]["position"]["x"])


def localization(tested: FleetWithAgv, published: Published) -> str:
    tested.robot.tick()
    return str(json.loads(published.newest["amcl/status"])["data"])


def orders(tested: FleetWithAgv) -> int:
    """Return the number of orders that the AGV gets when a path begins where it stood first."""
    tested.robot._follow(path("a", (0.0, 0.0), (3.0, 0.0)))
    tested.robot.tick()
    asyncio.run(tested.obey())
    return len(tested.agv.orders)


@pytest.mark.parametrize("version", Version)
@pytest.mark.parametrize("end", ["OFFLINE", "CONNECTION_BROKEN"])
def test_an_agv_that_restarts_with_its_clock_behind_is_heard(version: Version, end: ConnectionState):
    tested, published = connected(version)
    online(tested, end)
    tested.header_ids(0)
    tested.clock = -HOUR
    tested.agv.pose = ELSEWHERE
    online(tested, "ONLINE")
    assert localization(tested, published) == "the AGV has sent no state since its connection began"
    tested.robot._pose_at = float("-inf")
    state(tested)
    assert localization(tested, published) == ""
    assert pose(published) == ELSEWHERE.x


def test_an_agv_that_restarts_unnoticed_is_not_believed_at_its_old_place_and_then_heard():
    tested, published = connected()
    tested.header_ids(0)
    tested.clock = -HOUR
    tested.agv.pose = ELSEWHERE
    state(tested)
    assert localization(tested, published) == "states of the AGV are left out: late message 0 on state"
    assert orders(tested) == 0
    tested.robot._cancel("a")
    for _ in range(4):
        state(tested)
    assert localization(tested, published) == ""


def wrong_version(text: str) -> str:
    return text.replace('"version":"2.1.0"', '"version":"1.1.0"')


def no_errors(text: str) -> str:
    return text.replace('"errors":[]', '"errors":null')


def other_agv(text: str) -> str:
    return text.replace('"serialNumber":"fork-7"', '"serialNumber":"fork-8"')


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (wrong_version, "field 'version' is '1.1.0'"),
        (no_errors, "`$.errors`"),
        (other_agv, "names AGV 'acme/fork-8'"),
        (lambda text: text[:-9], "not JSON"),
    ],
)
def test_an_agv_whose_states_are_refused_is_not_localized_and_gets_no_order(
    damage: Callable[[str], str], words: str, caplog: pytest.LogCaptureFixture
):
    tested, published = connected()
    assert localization(tested, published) == ""
    for _ in range(10):
        payload = tested.payload(topics.STATE, tested.agv.state()).decode()
        assert damage(payload) != payload
        tested.fleet.receive(tested.address.topic(topics.STATE), damage(payload).encode(), False)
    published.newest.pop("amcl_pose")
    tested.robot._pose_at = float("-inf")
    told = localization(tested, published)
    assert told.startswith("states of the AGV are left out") and words in told
    assert "amcl_pose" not in published.newest
    assert caplog.text.count("is left out") == 1
    assert orders(tested) == 0
    (first, *_) = decode(DiagnosticArray, published.newest["diagnostics"]).status
    assert (first.name, first.level) == ("acme/fork-7: AGV", 2)
    assert first.message.startswith(
        f"{told} (connection ONLINE, version 2.1.0, newest state 0 s ago, messages left out 1"
    )
    assert ", operating mode AUTOMATIC, map hall, " in first.message
    state(tested)
    asyncio.run(tested.obey())
    assert localization(tested, published) == ""
    assert len(tested.agv.orders) == 1


def test_messages_that_differ_in_a_number_only_are_logged_once(caplog: pytest.LogCaptureFixture):
    tested, published = connected()
    for number in range(20, 10, -1):
        tested.header_ids(number)
        tested.clock = -HOUR
        state(tested)
    assert caplog.text.count("is left out") == 1
    assert localization(tested, published).endswith("late message 20 on state")


def test_an_agv_that_sends_a_state_without_a_position_is_not_believed_at_its_old_place():
    tested, published = connected()
    tested.say(topics.STATE, tested.agv.lie(mobile_robot_position=None))
    assert localization(tested, published) == "the AGV does not know where it is"
    assert orders(tested) == 0


@pytest.mark.parametrize("far", [1e300, -2e9])
def test_an_agv_whose_position_is_beyond_all_places_is_not_believed(far: float):
    tested, published = connected()
    position = tested.agv.state().mobile_robot_position
    assert position is not None
    tested.say(topics.STATE, tested.agv.lie(mobile_robot_position=msgspec.structs.replace(position, x=far)))
    assert localization(tested, published) == "the AGV does not know where it is"
    assert orders(tested) == 0
    assert "amcl_pose" not in published.newest


def test_an_agv_on_another_map_gets_no_order():
    tested, published = connected()
    tested.agv.map_id = "cellar"
    state(tested)
    assert localization(tested, published).startswith("the AGV is on map 'cellar', and its robot on 'hall'")
    assert orders(tested) == 0


def test_an_agv_that_says_nothing_any_more_is_not_believed(monkeypatch: pytest.MonkeyPatch):
    tested, published = connected()
    now = agv_robot.monotonic()
    monkeypatch.setattr(agv_robot, "monotonic", lambda: now + agv_robot.STATE_AGE + 1.0)
    assert "has sent no state that counts for 45 s" in localization(tested, published)
    assert orders(tested) == 0
