"""Roles, and messages that name their sender."""

import json

import pytest

from engine.rights.roles import check_may_publish, signed
from ppaas.errors import MalformedMessage, NotPermitted


def test_a_command_names_the_user_who_sent_it_whatever_it_says_itself() -> None:
    said = b'{"id": "a", "number": 1, "driver": "somebody else"}'
    assert json.loads(signed("teleop_cmd", said, "ada")) == {"id": "a", "number": 1, "driver": "ada"}


def test_messages_of_other_topics_are_left_as_they_are() -> None:
    assert signed("cmd_vel", b"{not read", "ada") == b"{not read"


@pytest.mark.parametrize("said", [b"[]", b'{"linear": NaN}', b"{", b'"text"'])
def test_a_command_that_cannot_be_signed_is_refused(said: bytes) -> None:
    with pytest.raises(MalformedMessage, match="teleop_cmd"):
        signed("teleop_cmd", said, "ada")


def test_no_operator_says_what_a_robot_does_for_its_driver() -> None:
    with pytest.raises(NotPermitted, match="teleop_state"):
        check_may_publish("operator", "teleop_state")
