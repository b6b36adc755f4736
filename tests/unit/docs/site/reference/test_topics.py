"""The pages of topics and messages have all of those that clones have."""

import re

from docs.site.reference import messages, topics
from docs.site.reference.clones import members
from docs.site.reference.markdown import slug
from ppaas.nodes.topics import CMD_VEL, MAP, SCAN, TOPICS

TEXT, MESSAGES = topics.page(), messages.page()


def test_each_topic_of_the_table_and_each_service_has_a_row() -> None:
    rows = re.findall(r"^\| `([\w/]+)` \|", TEXT, re.MULTILINE)
    services = {service.name for member in members() for service in member.node.services}
    assert {*TOPICS, *services} - set(rows) == set()


def test_rows_have_nodes_and_delivery() -> None:
    assert "| `cmd_vel` | [`geometry_msgs/Twist`](messages.md#geometry_msgstwist) | `move_base` |" in TEXT
    assert topics.delivery(MAP) == ["latched", "lasting"]
    assert topics.delivery(SCAN) == ["stream", "robot only"]
    assert topics.delivery(CMD_VEL) == ["stream"]


def test_each_type_that_is_named_has_a_section() -> None:
    sections = {slug(heading) for heading in re.findall(r"^#+ (.*)$", MESSAGES, re.MULTILINE)}
    assert set(re.findall(r"messages\.md#([\w-]+)", TEXT)) | set(re.findall(r"\]\(#([\w-]+)", MESSAGES)) <= sections
    assert "| `linear` | [`geometry_msgs/Vector3`](#geometry_msgsvector3) |" in MESSAGES
