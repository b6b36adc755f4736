"""Latch on the robot: what local nodes command passes only while the clone says that the robot is not stopped."""

import asyncio
from collections.abc import Callable

import msgspec
import pytest

from ppaas.messages import decode, encode
from ppaas.messages.geometry_msgs import Twist, Vector3
from ppaas.messages.health.stops import StopState
from robots.onboard import stop_latch
from robots.onboard.stop_latch import OnboardLatch

FAST = msgspec.Raw(encode(Twist(Vector3(x=0.5))))
STOPPED, FREE = StopState(stopped=True, text="stopped by 'ann'"), StopState()


class Cloud:
    """Client of a cloud that answers each subscription with the last state, unless it is mute."""

    def __init__(self, state: StopState | None = FREE) -> None:
        self.connections = 1
        self.state = state
        self.mute = False
        self.subscriptions: list[Callable[[StopState], None]] = []
        self.delivered: list[Twist] = []

    async def subscribe(self, topic: str, kind: type[StopState], callback: Callable[[StopState], None]) -> object:
        assert (topic, kind) == ("stop/state", StopState)
        self.subscriptions.append(callback)
        if self.state is not None and not self.mute:
            callback(self.state)
        return callback

    async def unsubscribe(self, subscription: Callable[[StopState], None]) -> None:
        self.subscriptions.remove(subscription)

    def deliver(self, topic: str, payload: msgspec.Raw) -> None:
        assert topic == "cmd_vel"
        self.delivered.append(decode(Twist, payload))

    def say(self, state: StopState) -> None:
        self.state = state
        [hear] = self.subscriptions
        hear(state)


async def latch(cloud: Cloud) -> OnboardLatch:
    made = OnboardLatch(cloud)  # type: ignore[arg-type]
    await made.open()
    return made


def passes(made: OnboardLatch) -> bool:
    passed = made.passed("cmd_vel", FAST)
    assert passed in (FAST, stop_latch.ZERO)
    return passed == FAST


async def soon() -> None:
    for _ in range(5):
        await asyncio.sleep(0)


async def test_zero_passes_while_the_robot_is_stopped_and_other_topics_as_they_are() -> None:
    cloud = Cloud()
    made = await latch(cloud)
    assert passes(made)
    cloud.say(STOPPED)
    assert not passes(made)
    assert made.passed("plan", FAST) == FAST
    cloud.say(FREE)
    assert passes(made)
    await made.close()


async def test_zero_is_delivered_at_once_and_again_although_local_nodes_are_silent(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(stop_latch, "PERIOD", 0.0)
    cloud = Cloud()
    made = await latch(cloud)
    cloud.say(STOPPED)
    await soon()
    assert len(cloud.delivered) > 1 and set(map(encode, cloud.delivered)) == {encode(Twist())}
    cloud.say(FREE)
    await soon()
    before = len(cloud.delivered)
    await soon()
    assert len(cloud.delivered) == before
    await made.close()


async def test_a_stop_holds_while_there_is_no_connection() -> None:
    cloud = Cloud(STOPPED)
    made = await latch(cloud)
    cloud.mute = True
    await soon()
    assert not passes(made)
    await made.close()


@pytest.mark.parametrize("state", [STOPPED, FREE])
async def test_nothing_passes_on_another_connection_until_the_state_has_come(state: StopState) -> None:
    cloud = Cloud()
    made = await latch(cloud)
    cloud.state, cloud.connections = state, 2
    assert not passes(made), "it may have been stopped meanwhile"
    await soon()
    assert passes(made) == (not state.stopped)
    assert len(cloud.subscriptions) == 1
    await made.close()


async def test_it_asks_once_for_each_connection() -> None:
    cloud = Cloud()
    made = await latch(cloud)
    cloud.mute = True
    for cloud.connections in (2, 3):
        for _ in range(10):
            assert not passes(made)
            await soon()
    cloud.say(FREE)
    assert passes(made)
    await made.close()


async def test_a_cloud_without_stops_holds_nothing(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(stop_latch, "PATIENCE", 0.01)
    cloud = Cloud(None)
    made = await latch(cloud)
    assert "stops do not hold local nodes" in caplog.text
    cloud.connections = 2
    assert passes(made)
    await made.close()
