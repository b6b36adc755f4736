"""Robot of an AGV in the cloud, whose frames are given to its link."""

import json
from collections.abc import Coroutine
from typing import Any

import pytest

from ppaas.geometry import Pose2D
from ppaas.messages import encode
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose, PoseStamped, PoseWithCovariance, PoseWithCovarianceStamped
from ppaas.messages.nav_msgs import Path
from ppaas.wire.own_topics import PRESENCE
from ppaas.wire.vda5050.agv.agv import Abilities, Agv
from ppaas.wire.vda5050.agv.report import Telemetry, state_of
from ppaas.wire.vda5050.states import PowerSupply
from ppaas.wire.vda5050.topics import Version
from robots.bridges.core.cloud_link import CloudLink
from robots.bridges.vda5050 import clone_side
from robots.bridges.vda5050.agv_options import AgvOptions
from robots.bridges.vda5050.clone_side import CloneSide
from tests.support.vda5050.orders import MAP


class Clone:
    """Clone of a robot that is an AGV of version 3.0."""

    def __init__(self) -> None:
        self.agv = Agv(Version.V3_0, Abilities(MAP))
        self.telemetry = Telemetry(PowerSupply(state_of_charge=50.0, charging=False))
        self._link = CloudLink("http://127.0.0.1:9", robot="tb1", token="token", operator=True)
        self.side = CloneSide(
            self.agv, self.telemetry, self._link, AgvOptions(Version.V3_0), changed=lambda: None, start=_refuse
        )

    def say(self, topic: str, message: object) -> None:
        """Let the cloud send a message of a topic."""
        self._link._receive(json.dumps({"op": "publish", "topic": topic, "msg": message}))


def _refuse(work: Coroutine[Any, Any, None]) -> None:
    raise AssertionError(f"nothing is to be started: {work}")


async def test_a_robot_tells_its_pose_path_and_battery() -> None:
    clone = Clone()
    await clone.side.subscribe()
    header, pose = Header(frame_id="map"), Pose.of(Pose2D(1.0, 2.0, 0.5))
    covariance = [0.01 if index in (0, 7) else 0.0 for index in range(36)]
    located = PoseWithCovarianceStamped(header, PoseWithCovariance(pose, covariance))
    clone.say("amcl_pose", json.loads(encode(located)))
    clone.say("plan", json.loads(encode(Path(header, [PoseStamped(header, pose)]))))
    clone.say("battery_state", {"percentage": 0.25, "voltage": 12.5, "current": None, "power_supply_status": 1})
    found = clone.agv.pose
    assert found is not None and found.theta == pytest.approx(0.5)
    assert (found.x, found.y, found.deviation) == pytest.approx((1.0, 2.0, 0.02**0.5))
    assert clone.telemetry.path == [(1.0, 2.0)]
    power = clone.telemetry.power
    assert (power.state_of_charge, power.charging, power.battery_voltage) == (25.0, True, 12.5)


async def test_an_agv_is_connected_while_its_robot_is() -> None:
    clone = Clone()
    await clone.side.subscribe()
    clone.side.check()
    assert not clone.agv.connected  # the link is not up
    clone._link._keeper.connected.set()
    clone.side.check()
    assert clone.agv.connected
    clone.say(PRESENCE, {"data": False})
    assert not clone.agv.connected
    clone.say(PRESENCE, {"data": True})
    assert clone.agv.connected


@pytest.mark.parametrize("topic", ["amcl_pose", "odom", "plan", "battery_state"])
@pytest.mark.parametrize("message", [{"percentage": "full", "pose": 3, "twist": [], "poses": {}}, [], None, 7])
async def test_a_message_that_is_not_of_its_type_is_left_out(topic: str, message: object) -> None:
    clone = Clone()
    await clone.side.subscribe()
    clone.say(topic, message)
    assert clone.agv.pose is None and clone.telemetry.path == ()
    assert clone.telemetry.power.state_of_charge == 50.0


async def test_a_robot_whose_pose_is_not_renewed_is_not_localized_and_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    clone = Clone()
    await clone.side.subscribe()
    clone._link._keeper.connected.set()
    header, pose = Header(frame_id="map"), PoseWithCovariance(Pose.of(Pose2D(1.0, 2.0, 0.5)))
    located = json.loads(encode(PoseWithCovarianceStamped(header, pose)))

    def errors() -> list[tuple[str, str | None]]:
        state = state_of(clone.agv, MAP, clone.telemetry)
        assert state.mobile_robot_position is not None
        assert state.mobile_robot_position.localized is (not state.errors)
        return [(error.error_type, error.error_description) for error in state.errors]

    clone.side.check()
    clone.say("amcl_pose", located)
    assert errors() == []
    now = clone_side.monotonic()
    with monkeypatch.context() as later:
        later.setattr(clone_side, "monotonic", lambda: now + 9.0)
        clone.side.check()
    assert errors() == [("LOCALIZATION_ERROR", "the robot is not localized: no pose of the robot has come for 3 s")]
    clone.say("amcl/status", {"data": "no scan comes any more"})
    assert errors() == [("LOCALIZATION_ERROR", "the robot is not localized: no scan comes any more")]
    clone.say("amcl_pose", located)
    assert errors() == []
