"""Messages between the processes of a cloud: a release understands the release before, by checked-in schemas.

``wire/schema-N.json`` has the messages of protocol N, and ``wire/samples-N.json`` a message of each kind as its release
sent it. After a change of a message that is not released yet, ``python -m tests.support.engine.wire_schema`` writes the
files of the newest protocol again; those of earlier protocols never change. The first change after a release needs a
new protocol: the next number in ``engine.protocols.versions.OWN``.
"""

import copy
import json
from collections.abc import Callable
from typing import Any

import msgspec
import pytest

from engine.protocols.versions import OWN
from tests.support.engine.wire_schema import FOLDER, LINKS, Schema, breaks, sample, schema, structs_of


def stored(kind: str, number: int) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((FOLDER / f"{kind}-{number}.json").read_text())
    return found


NOW = json.loads(msgspec.json.encode(schema()))
SPOKEN = range(OWN.oldest, OWN.newest + 1)


def test_the_messages_are_those_of_the_newest_protocol() -> None:
    assert stored("schema", OWN.newest) == NOW, "run python -m tests.support.engine.wire_schema"


@pytest.mark.parametrize("number", SPOKEN)
def test_each_spoken_protocol_is_understood(number: int) -> None:
    assert list(breaks(stored("schema", number), NOW)) == []


@pytest.mark.parametrize("number", SPOKEN)
@pytest.mark.parametrize("link", LINKS)
def test_messages_of_each_spoken_protocol_are_read(link: str, number: int) -> None:
    known = {one.__name__: one for one in structs_of(LINKS[link])}
    for name, packed in stored("samples", number)[link].items():
        message = msgspec.msgpack.decode(bytes.fromhex(packed), type=LINKS[link])
        assert type(message) is known[name]


@pytest.mark.parametrize("link", LINKS)
def test_each_message_has_a_sample_of_the_newest_protocol(link: str) -> None:
    packed = stored("samples", OWN.newest)[link]
    assert packed == {one.__name__: msgspec.msgpack.encode(sample(one)).hex() for one in structs_of(LINKS[link])}


# -- the check itself --------------------------------------------------------------------------------------------------


def without_the_default_of_a_new_field(changed: Schema) -> None:
    changed["types"]["Welcome"]["properties"]["new"] = {"type": "integer"}
    changed["types"]["Welcome"]["required"].append("new")


def without_a_field(changed: Schema) -> None:
    del changed["types"]["StopContainer"]["properties"]["container"]
    changed["types"]["StopContainer"]["required"].remove("container")


def of_another_type(changed: Schema) -> None:
    changed["types"]["StopContainer"]["properties"]["container"] = {"type": "integer"}


def without_a_message(changed: Schema) -> None:
    changed["links"]["control link, to agents"].remove("Dismissed")


def without_a_method(changed: Schema) -> None:
    del changed["methods"]["MasterCalls.join"]


def with_another_argument(changed: Schema) -> None:
    changed["methods"]["MasterCalls.leave"] = {"new": {"type": "integer"}, **changed["methods"]["MasterCalls.leave"]}


@pytest.mark.parametrize(
    ("change", "found"),
    [
        (without_the_default_of_a_new_field, "Welcome: field new has no default"),
        (without_a_field, "StopContainer: field container, which has no default in the release before, was removed"),
        (of_another_type, "StopContainer: field container is of another type"),
        (without_a_message, "control link, to agents: Dismissed was removed"),
        (without_a_method, "method MasterCalls.join was removed"),
        (with_another_argument, "method MasterCalls.leave has other arguments, or another result"),
    ],
)
def test_a_change_that_the_release_before_does_not_understand_is_found(
    change: Callable[[Schema], None], found: str
) -> None:
    changed = copy.deepcopy(NOW)
    change(changed)
    assert list(breaks(NOW, changed)) == [found]


def test_a_new_message_and_a_new_field_with_a_default_are_understood() -> None:
    changed = copy.deepcopy(NOW)
    changed["links"]["control link, to agents"].append("New")
    changed["types"]["Welcome"]["properties"]["new"] = {"type": "integer", "default": 0}
    changed["methods"]["MasterCalls.new"] = {}
    assert list(breaks(NOW, changed)) == []
