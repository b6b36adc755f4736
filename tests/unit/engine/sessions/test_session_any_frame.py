"""Thousands of generated frames: none breaks the cloud or disturbs another client.

The frames are made by Hypothesis, most of them nearly right: the operations, names, types and ids of a clone that is
there, with anything else in the fields. What a frame asks of the place is done for real; its container is a stand-in
that answers with whatever Hypothesis thinks of as well.
"""

import asyncio
import json
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from engine.protocols import robot_link
from tests.support.budget import examples
from tests.support.endpoints.any_frame import FRAME, JSON
from tests.support.endpoints.still_place import TOPICS, StillClient, StillPlace

FRAMES = 40
"""Number of frames per example."""

PUBLISHED = st.tuples(st.sampled_from([topic.name for topic in TOPICS]), JSON)
CLIENT_OPERATIONS = {
    "publish", "status", "service_response", "call_service", "action_result", "action_feedback", "send_action_goal",
    "cancel_action_goal", "png",
}  # fmt: skip


class Bystander:
    """Well-behaved client: it receives its topic, and its messages reach the container, whatever other clients do."""

    def __init__(self, place: StillPlace) -> None:
        self._place = place
        self._client = StillClient(place, "operator")
        self._client.say(op="subscribe", topic="/cmd_vel", type="geometry_msgs/Twist")
        self._count = 0

    async def is_served(self) -> bool:
        """Return whether it receives a velocity and nothing else, and its own message reaches the container."""
        self._count += 1
        self._client.received()
        self._place.publish_json("cmd_vel", {"linear": {"x": self._count}})
        received = self._client.received()
        [velocity] = [frame for frame in received if frame["op"] == "publish"]
        others = [frame for frame in received if frame is not velocity]
        self._client.say(op="publish", topic="goal", msg={"data": self._count})
        last = self._place.far.take(robot_link.Deliver)[-1]
        return (
            others == []
            and velocity["msg"] == {"linear": {"x": self._count}}
            and (last.topic, json.loads(last.payload)) == ("goal", {"data": self._count})
        )

    def end(self) -> None:
        self._client.session.end()


@pytest.mark.filterwarnings("error", "default::ResourceWarning")  # these may be of earlier tests
@settings(max_examples=examples(60), suppress_health_check=list(HealthCheck), database=None)
@given(st.lists(FRAME, min_size=FRAMES, max_size=FRAMES), st.lists(PUBLISHED, max_size=2))
async def test_no_frame_breaks_the_cloud_or_disturbs_another(frames: list[str | bytes], published: list[Any]) -> None:
    place = StillPlace()
    bystander, client = Bystander(place), StillClient(place)
    for frame in frames:
        client.send(frame)
        await asyncio.sleep(0)
        for call in place.far.take(robot_link.ServiceCall):
            place.say(robot_link.ServiceAnswer(call.call, b"{}"))
    for topic, message in published:
        place.publish_json(topic, message)
    assert not client.session.over.done()
    assert await bystander.is_served()
    assert {frame["op"] for frame in client.received()} <= CLIENT_OPERATIONS
    client.session.end()
    assert place.client_topics.types() == place.client_services.types() == place.client_actions.types() == {}
    assert place.client_actions.goals == 0
    assert await bystander.is_served()
    bystander.end()
    assert place._clients == {} and place._hearers == {}
