"""Clients of a chaos run that subscribe with throttle rates, and what they check."""

import asyncio
import contextlib

import pytest

from benchmarks.chaos.clients import THROTTLES, ThrottledClient
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, GoalStatus
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseStamped, PoseWithCovariance, PoseWithCovarianceStamped
from ppaas.messages.move_base_msgs import MoveBaseActionFeedback, MoveBaseFeedback
from tests.support.endpoints.rosbridge_server import rosbridge_server
from tests.support.waiting import patience, until


def pose(stamp: float) -> PoseWithCovarianceStamped:
    return PoseWithCovarianceStamped(
        Header(stamp=Time.of(stamp), frame_id="map"), PoseWithCovariance(Pose.of(Pose2D(1.0, 2.0, 0.0)))
    )


def feedback(stamp: float) -> MoveBaseActionFeedback:
    where = PoseStamped(Header(), Pose.of(Pose2D(1.0, 2.0, 0.0)))
    return MoveBaseActionFeedback(Header(stamp=Time.of(stamp)), GoalStatus(GoalID(), 1), MoveBaseFeedback(where))


@pytest.fixture
def errors() -> list[str]:
    """Return the errors that a client has reported."""
    return []


async def test_it_subscribes_with_throttle_rates_and_again_after_its_connection_ended(errors: list[str]) -> None:
    async with patience(30.0), rosbridge_server() as server:
        run = asyncio.create_task(ThrottledClient((server.url, "t"), "r", 1, errors.append).run())
        await until(lambda: len(server.of("subscribe")) == 2)
        await server.connections[0].close()
        await until(lambda: len(server.of("subscribe")) == 4)
        run.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await run
    rates = [frame["throttle_rate"] for frame in server.of("subscribe")]
    assert rates == [round(1000.0 * THROTTLES[1]), round(1000.0 * THROTTLES[2])] * 2


def test_messages_that_become_newer_are_right(errors: list[str]) -> None:
    client = ThrottledClient(("", ""), "r", 0, errors.append)
    for stamp in (1.0, 1.5, 1.5, 2.0):
        client.on_message("amcl_pose", pose(stamp))
    for stamp in (0.5, 1.0):
        client.on_message("move_base/feedback", feedback(stamp))
    client.check()
    assert (client.messages, errors) == (6, [])


@pytest.mark.parametrize(("second", "how"), [(2.0, "again"), (1.5, "0.500 s older than the last one")])
def test_messages_that_come_again_or_late_are_reported(errors: list[str], second: float, how: str) -> None:
    client = ThrottledClient(("", ""), "r", 4, errors.append)
    client.on_message("move_base/feedback", feedback(2.0))
    client.on_message("move_base/feedback", feedback(second))
    assert errors == [f"throttled client 4 of r received move_base/feedback {how}"]


def test_poses_that_come_late_are_reported(errors: list[str]) -> None:
    client = ThrottledClient(("", ""), "r", 4, errors.append)
    client.on_message("amcl_pose", pose(2.0))
    client.on_message("amcl_pose", pose(1.0))
    assert errors == ["throttled client 4 of r received amcl_pose 1.000 s older than the last one"]


def test_a_client_that_received_nothing_is_reported(errors: list[str]) -> None:
    ThrottledClient(("", ""), "r", 2, errors.append).check()
    assert errors == ["throttled client 2 of r received nothing"]
