"""Tests of ``ppaas robot go``, ``state``, ``stop`` and ``move``."""

import asyncio
import json
from pathlib import Path

import pytest

from engine.control import robot_navigation
from engine.master.places import robot_key
from engine.protocols import robot_link
from robots.cli.verbs import robot_goals
from tests.support.cloud.command_line import CommandLine
from tests.support.endpoints.still_place import StillRobot
from tests.support.geojson import collection, feature
from tests.support.storage import records

FILE = Path("docs/examples/office.yaml")
OFFICE = records.GivenMap("house", "ann", FILE.read_bytes(), FILE.with_suffix(".pgm").read_bytes())


@pytest.fixture(autouse=True)
def _short_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(robot_navigation, "POSE_TIMEOUT", 0.01)
    monkeypatch.setattr(robot_goals, "POLL", 0.01)


@pytest.fixture
def place(ppaas: CommandLine) -> StillRobot:
    """Return the place of ann's robot."""
    ppaas.services.store.put_robot(records.robot("tb1", user="ann"))
    made = StillRobot()
    ppaas.services.cloud.connect("ann", "tb1", made)  # type: ignore[attr-defined]
    return made


class EndingPlace(StillRobot):
    """Place whose Move Base ends each goal at once."""

    def __init__(self, status: int, text: str) -> None:
        super().__init__()
        self._status, self._text = status, text

    def deliver(self, topic: str, payload: bytes, client: int, *, must_arrive: bool) -> int:
        sequence = super().deliver(topic, payload, client, must_arrive=must_arrive)
        if topic == "move_base/goal":
            self._end_soon(json.loads(payload)["goal_id"]["id"])
        return sequence

    def _end_soon(self, goal: str) -> None:
        status = {"goal_id": {"id": goal}, "status": self._status, "text": self._text}
        result = {"header": {"frame_id": ""}, "status": status}
        asyncio.get_running_loop().call_soon(self.publish_json, "move_base/result", result)


async def test_a_robot_is_sent_to_a_station(ppaas: CommandLine, place: StillRobot, tmp_path: Path) -> None:
    records.put_map(ppaas.services.map_store, OFFICE)
    point = {"type": "Point", "coordinates": [2.0, 3.0]}
    zones = tmp_path / "zones.geojson"
    zones.write_bytes(collection(feature(point, name="the ramp", kind="station", yaw=1.5)))
    assert (await ppaas("map", "zones", "house", "--put", str(zones))).status == 0
    gone = await ppaas("robot", "go", "tb1", "the", "ramp", "--json")
    assert json.loads(gone.out)["pose"] == [2.0, 3.0, 1.5], gone.err
    assert "do you mean 'the ramp'?" in (await ppaas("robot", "go", "tb1", "the", "rmp")).err


async def test_a_goal_is_sent_and_the_state_shows_it(ppaas: CommandLine, place: StillRobot) -> None:
    sent = json.loads((await ppaas("robot", "go", "tb1", "4.0", "1.5", "--json")).out)
    assert (sent["pose"], sent["state"]) == ([4.0, 1.5, 0.0], "pending")
    assert (await ppaas("robot", "state", "tb1")).rows[1][-1] == sent["id"]
    assert (await ppaas("robot", "stop", "tb1")).status == 0
    cancels = [frame for frame in place.far.take(robot_link.Deliver) if frame.topic == "move_base/cancel"]
    assert len(cancels) == 1


async def test_the_state_says_that_a_robot_left_and_that_its_container_waits(
    ppaas: CommandLine, place: StillRobot
) -> None:
    ppaas.services.cloud.presence.left(robot_key("ann", "tb1"))  # type: ignore[attr-defined]
    heading, row = (await ppaas("robot", "state", "tb1")).rows
    assert heading[:3] == ["connected", "disconnected_since", "container"]
    assert row[0] == "no"
    [listed] = json.loads((await ppaas("robot", "list", "--json")).out)
    assert listed["connected"] is False
    assert (await ppaas("robot", "list")).rows[1][:2] == ["tb1", "offline"]
    assert (await ppaas("robot", "go", "tb1", "1", "1")).status == 1


@pytest.mark.parametrize(("status", "text", "expected"), [(3, "", 0), (4, "no path", 1)])
async def test_waiting_ends_with_the_goal(ppaas: CommandLine, status: int, text: str, expected: int) -> None:
    ppaas.services.store.put_robot(records.robot("tb1", user="ann"))
    ppaas.services.cloud.connect("ann", "tb1", EndingPlace(status, text))  # type: ignore[attr-defined]
    ended = await ppaas("robot", "go", "tb1", "4", "1", "1.57", "--wait")
    assert ended.status == expected
    assert ("the goal was not reached: aborted: no path" in ended.err) == bool(expected)


async def test_a_robot_that_is_not_connected_takes_no_goal(ppaas: CommandLine) -> None:
    ppaas.services.store.put_robot(records.robot("tb1", user="ann"))
    assert "robot 'tb1' is not connected" in (await ppaas("robot", "go", "tb1", "4", "1")).err


async def test_a_robot_is_moved_to_another_map(ppaas: CommandLine) -> None:
    store = ppaas.services.store
    store.put_robot(records.robot("tb1", user="ann", map="house"))
    records.put_map(ppaas.services.map_store, records.house("house-2"))
    ended = await ppaas("robot", "move", "tb1", "--map", "house-2", "--at", "-4", "2", "0.5", "--json")
    shown = json.loads(ended.out)
    assert (shown["map"], shown["initial_pose"]) == ("house-2", [-4.0, 2.0, 0.5])
    assert store.robot("ann", "tb1").initial_pose == (-4.0, 2.0, 0.5)
