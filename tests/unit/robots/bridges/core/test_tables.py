"""Topics that a bridge carries: both sides know their types."""

import json

import pytest

from ppaas.messages import decode
from ppaas.nodes.topics import TOPICS
from ppaas.wire.ros import ros_types
from robots.bridges.core.tables import DOWN, PARTICLES, SERVICES, UP, DownTopic, UpTopic

RELEASES = ("humble", "jazzy", "kilted")


@pytest.mark.parametrize("release", RELEASES)
def test_each_release_knows_the_types(release: str) -> None:
    types = ros_types(release)
    assert [topic.cloud for topic in (*UP, *DOWN) if topic.type not in types] == []
    assert [service.name for service in SERVICES if not types.knows(service.type)] == []


@pytest.mark.parametrize("topic", [one for one in UP if one.clone], ids=lambda topic: topic.cloud)
def test_the_clone_reads_what_the_robot_publishes(topic: UpTopic) -> None:
    types = ros_types("jazzy")
    text = types.decode_json(topic.type, types.encode(topic.type, {}))
    assert decode(TOPICS[topic.cloud].type, text) is not None


@pytest.mark.parametrize("topic", [one for one in DOWN if one is not PARTICLES], ids=lambda topic: topic.cloud)
def test_the_robot_reads_what_the_clone_publishes(topic: DownTopic) -> None:
    types = ros_types("jazzy")
    empty = types.decode_json(topic.type, types.encode(topic.type, {}))
    fields = json.loads(empty).keys()
    assert TOPICS[topic.cloud].type.__struct_fields__ == tuple(fields)
