"""URDFs as robots have them, for topics and parameters."""

import pytest

from ppaas.messages.base.std_msgs import String
from ppaas.nodes.tf.urdf_text import UrdfText
from tests.support.world.urdf import example


@pytest.mark.parametrize(
    "text", ["<robot name='r'/>", "<?xml version='1.0' encoding='utf-8'?>\n<robot name='Zoë'/>\r\n"]
)
def test_a_urdf_is_returned_as_it_was_stored(text: str) -> None:
    assert UrdfText.of(text.encode()).text() == text


def test_a_byte_order_mark_is_left_out() -> None:
    assert UrdfText.of(b"\xef\xbb\xbf<robot/>").to_message() == String("<robot/>")


def test_a_urdf_takes_a_part_of_its_memory() -> None:
    urdf = example("turtlebot3_waffle")
    assert len(UrdfText.of(urdf).compressed) < len(urdf) / 2
    assert UrdfText.of(urdf) == UrdfText.of(urdf)
