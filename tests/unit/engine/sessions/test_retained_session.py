"""Reports of settled frames to the endpoint that keeps them."""

import asyncio
import json

import msgspec
import pytest

from engine.protocols.session_frames import Attach, NumberedFrame, SessionClient, SessionOptions, Settled, SocketFrame
from engine.rights.access import Access
from engine.sessions import retained_session
from engine.sessions.retained_session import RetainedSession
from engine.sessions.socket_sink import SocketSink
from tests.support.endpoints.still_place import StillPlace
from tests.support.waiting import until

PERIOD = 0.05


class _Link:
    """Link to an endpoint, which records what is written."""

    waiting = 0

    def __init__(self) -> None:
        self.written: list[msgspec.Struct] = []

    def write(self, frame: msgspec.Struct) -> None:
        self.written.append(frame)


@pytest.fixture
async def session(monkeypatch: pytest.MonkeyPatch) -> tuple[RetainedSession, _Link]:
    monkeypatch.setattr(retained_session, "REPORT_PERIOD", PERIOD)
    client = SessionClient("ann", "ann", "tb1", "robot")
    made, link = (
        RetainedSession(StillPlace(), Attach(1, client, SessionOptions(), Access.of_owner("tb1"), "s")),
        _Link(),
    )
    made.connect(SocketSink(link, 1, made.unsettled))
    return made, link


def _odometry(number: int) -> NumberedFrame:
    return NumberedFrame(number, json.dumps({"op": "publish", "topic": "odom", "msg": {}}).encode())


async def test_settled_frames_are_reported_together_after_a_while(session: tuple[RetainedSession, _Link]) -> None:
    made, link = session
    made.take(_odometry(1))
    made.take(_odometry(2))
    assert link.written == []
    await until(lambda: link.written)
    assert link.written == [Settled(1, [1, 2])]


async def test_frames_for_the_client_take_settled_ones_along_and_later_ones_are_reported_in_their_time(
    session: tuple[RetainedSession, _Link],
) -> None:
    made, link = session
    for number in range(1, 13):
        made.take(_odometry(number))
        made.session.outbox.put("cmd_vel", b"{}", 1)
        await asyncio.sleep(0.25 * PERIOD)
    assert {type(frame) for frame in link.written} == {SocketFrame}
    assert [frame.settled for frame in link.written] == [(number,) for number in range(1, 13)]  # type: ignore[attr-defined]
    made.take(_odometry(13))
    await until(lambda: len(link.written) > 12)
    assert link.written[12:] == [Settled(1, [13])]
