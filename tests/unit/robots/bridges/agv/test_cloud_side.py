"""Robot that an AGV is: its AGV pauses while the robot is stopped in the cloud."""

from collections.abc import Callable
from typing import Any

from ppaas.messages import encode
from ppaas.messages.health.stops import StopState
from robots.bridges.agv.cloud_side import CloudCallbacks, CloudSide


class Link:
    """Stands in for the link of the robot: the test publishes by it."""

    def __init__(self) -> None:
        self.hearers: dict[str, Callable[[bytes], Any]] = {}

    async def advertise(self, topic: str, kind: str) -> None:
        """Take an advertisement."""

    async def subscribe(self, topic: str, kind: str, hear: Callable[[bytes], Any]) -> None:
        self.hearers[topic] = hear


async def test_an_agv_pauses_while_its_robot_is_stopped_and_no_pause_of_others_is_ended() -> None:
    actions: list[str] = []
    nothing = [lambda *_: None] * 3
    side = CloudSide("http://127.0.0.1:9", "token", "fork-7", CloudCallbacks(*nothing, actions.append, lambda: None))
    link = Link()
    side.link = link  # type: ignore[assignment]
    await side.subscribe()
    for stopped in (False, True, True, False, False):
        link.hearers["stop/state"](encode(StopState(stopped=stopped)))
    assert actions == ["startPause", "stopPause"]
