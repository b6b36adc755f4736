"""Checkpoints and records: a release reads what the release before has stored, and the other way around.

During an upgrade a container moves back and forth between machines of two releases, and a standby of one continues from
what the leader of the other has stored. ``wire/stored-N.json`` has the schema of protocol N, and
``wire/stored-samples-N.json`` a sample of everything. ``python -m tests.support.engine.stored_schema`` writes the files
of the newest protocol again; those of earlier protocols change only where a type is renamed.
"""

import copy
import importlib
import json
import pkgutil
from collections.abc import Callable
from typing import Any

import jsonschema
import msgspec
import pytest

import ppaas.nodes
from engine.protocols.versions import OWN
from ppaas.nodes.base import Node
from tests.support.engine.stored_schema import (
    NODES,
    STORED,
    as_stored,
    breaks_of_stored,
    document,
    is_packed,
    read_stored,
    stored_samples,
    stored_schema,
)
from tests.support.engine.wire_schema import FOLDER, Schema


def checked_in(kind: str, number: int) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((FOLDER / f"{kind}-{number}.json").read_text())
    return found


NOW = json.loads(msgspec.json.encode(stored_schema()))
SPOKEN = range(OWN.oldest, OWN.newest + 1)


def test_what_is_stored_is_that_of_the_newest_protocol() -> None:
    assert checked_in("stored", OWN.newest) == NOW, "run python -m tests.support.engine.stored_schema"
    assert checked_in("stored-samples", OWN.newest)["samples"] == stored_samples()


@pytest.mark.parametrize("number", SPOKEN)
def test_nothing_changed_that_one_of_two_releases_cannot_read(number: int) -> None:
    assert list(breaks_of_stored(checked_in("stored", number), NOW)) == []


@pytest.mark.parametrize("number", SPOKEN)
def test_what_each_spoken_release_has_stored_is_read(number: int) -> None:
    for name, data in checked_in("stored-samples", number)["samples"].items():
        read_stored(name, bytes.fromhex(data))


@pytest.mark.parametrize("number", SPOKEN)
def test_what_this_release_stores_is_read_by_each_spoken_release(number: int) -> None:
    """Its schema allows the values; like its decoder, it ignores fields that it does not know."""
    schema = checked_in("stored", number)
    for name in schema["stored"]:
        jsonschema.validate(as_stored(name), document(schema, name))


def test_all_nodes_with_checkpoints_are_there() -> None:
    for module in pkgutil.walk_packages(ppaas.nodes.__path__, "ppaas.nodes."):
        if "kernels" not in module.name:
            importlib.import_module(module.name)
    assert {kind.name for kind in _subclasses(Node) if _keeps_state(kind)} == NODES.keys()


def _keeps_state(kind: type[Node]) -> bool:
    ours = kind.__module__.startswith(("ppaas.", "engine."))  # not of a test
    return ours and kind.checkpoint is not Node.checkpoint and hasattr(kind, "name")


def _subclasses(kind: type[Node]) -> set[type[Node]]:
    direct = set(kind.__subclasses__())
    return direct.union(*map(_subclasses, direct))


# -- the check itself --------------------------------------------------------------------------------------------------


def a_new_field_without_a_default(changed: Schema) -> None:
    changed["types"]["AmclState"]["properties"]["new"] = {"type": "integer"}
    changed["types"]["AmclState"]["required"].append("new")


def another_type(changed: Schema) -> None:
    changed["types"]["MoveBaseState"]["properties"]["counter"] = {"type": "string"}


def another_form(changed: Schema) -> None:
    changed["stored"]["checkpoint of explore"] = {"$ref": "Exploration"}


def a_node_less(changed: Schema) -> None:
    del changed["stored"]["checkpoint of stop"]


def a_field_that_is_refused(changed: Schema) -> None:
    changed["types"]["SavedCoordinator"]["properties"]["new"] = {"type": "integer", "default": 0}


@pytest.mark.parametrize(
    ("change", "found"),
    [
        (a_new_field_without_a_default, "AmclState: field new has no default"),
        (another_type, "MoveBaseState: field counter is of another type"),
        (another_form, "checkpoint of explore is of another type"),
        (a_node_less, "checkpoint of stop was removed"),
        (
            a_field_that_is_refused,
            "SavedCoordinator: field new is unknown to the release before, which refuses unknown fields",
        ),
    ],
)
def test_a_change_that_another_release_cannot_read_is_found(change: Callable[[Schema], None], found: str) -> None:
    changed = copy.deepcopy(NOW)
    change(changed)
    assert list(breaks_of_stored(NOW, changed)) == [found]


def test_a_new_field_with_a_default_is_read_by_both() -> None:
    changed = copy.deepcopy(NOW)
    changed["types"]["AmclState"]["properties"]["new"] = {"type": "integer", "default": 0}
    assert list(breaks_of_stored(NOW, changed)) == []


@pytest.mark.parametrize("name", STORED)
def test_a_value_of_another_type_is_refused_by_decoder_and_schema(name: str) -> None:
    """Otherwise neither check could fail."""
    encode = msgspec.msgpack.encode if is_packed(name) else msgspec.json.encode
    with pytest.raises(msgspec.MsgspecError):
        read_stored(name, encode(7))
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(7, document(NOW, name))
