"""Schema of the messages between the processes of a cloud, and what keeps two releases from understanding each other.

``python -m tests.support.engine.wire_schema`` writes the schema of the newest protocol, and a sample of each message.
"""

from collections.abc import Iterable, Iterator
from pathlib import Path
from types import UnionType
from typing import Any, get_args, get_type_hints

import msgspec

from endpoints.accounts.shared_logins import SharedLogins
from endpoints.accounts.user_turns import TurnCalls
from endpoints.audit.data_folder import DataFolderCalls
from endpoints.retention.calls import RetentionCalls
from endpoints.webhooks.calls import WebhookCalls
from engine.calls.caller import Frame
from engine.calls.interface import methods_of
from engine.control.journeys.calls import JourneyCalls
from engine.control.master_calls.control_plane import MasterParts
from engine.control.master_calls.interface import EndpointCalls, MasterCalls
from engine.protocols import control_link, machine_link, robot_link
from engine.protocols.address import EndpointAddress
from engine.protocols.versions import OWN
from engine.remote import joining, standbys
from engine.remote.cluster_settings import ClusterSettings
from ppaas.errors import PPaaSError
from ppaas.perception.depth_scan import PinholeCamera

FOLDER = Path(__file__).parents[2] / "unit" / "engine" / "protocols" / "wire"

LINKS: dict[str, Any] = {
    "control link, from agents": control_link.FromAgent,
    "control link, to agents": control_link.ToAgent,
    "robot link, from containers": robot_link.FromContainer,
    "robot link, to containers": robot_link.ToContainer,
    "machine link, from containers": machine_link.FromContainer,
    "machine link, to containers": machine_link.ToContainer,
    "calls": Frame,
    "relays": EndpointAddress,
    "settings": ClusterSettings,
    "standbys": standbys.StandbyHello,
    "to standbys": standbys.ToStandby,
    "joining": joining.Join | joining.Joined | joining.NotJoined,
}
"""Messages of each link."""

INTERFACES = (
    MasterCalls, EndpointCalls, SharedLogins, TurnCalls, DataFolderCalls, WebhookCalls, RetentionCalls,
    JourneyCalls,
    *get_type_hints(MasterParts).values(),
)  # fmt: skip
"""Methods that the master and endpoints call."""

Schema = dict[str, Any]


def structs_of(link: Any) -> tuple[type[msgspec.Struct], ...]:
    """Return the messages of a link."""
    return get_args(link) if isinstance(link, UnionType) else (link,)


def schema() -> Schema:
    """Return the schema: messages of each link, methods, and the fields of all types that they have."""
    methods = [(method.name, get_type_hints(function)) for method, function in _methods()]
    types = [hint for _, hints in methods for hint in hints.values()]
    shown, parts = msgspec.json.schema_components(
        [*types, *LINKS.values()], schema_hook=of_error, ref_template="{name}"
    )
    of_type = dict(zip(map(_key, types), shown, strict=False))
    return {
        "links": {name: sorted(one.__name__ for one in structs_of(link)) for name, link in LINKS.items()},
        "methods": {name: {arg: plain(of_type[_key(hint)]) for arg, hint in hints.items()} for name, hints in methods},
        "types": {name: plain(part) for name, part in sorted(parts.items())},
    }


def _methods() -> Iterator[tuple[Any, Any]]:
    for interface in INTERFACES:
        for method in methods_of(interface):
            yield method, getattr(interface, method.attribute)


def _key(hint: Any) -> str:
    return repr(hint)


def of_error(kind: type) -> Schema:
    """Return the schema of an error, which travels as its name and its text."""
    if issubclass(kind, PPaaSError):
        return {"title": "error"}
    raise NotImplementedError


def plain(part: Any) -> Any:
    """Return a schema without its texts."""
    if isinstance(part, dict):
        return {key: plain(value) for key, value in part.items() if key not in ("description", "title")}
    return [plain(one) for one in part] if isinstance(part, list) else part


# -- changes -----------------------------------------------------------------------------------------------------------


def breaks(before: Schema, after: Schema) -> Iterator[str]:
    """Yield the changes that keep a process of one schema from reading what a process of the other one sends."""
    for link, messages in before["links"].items():
        for gone in set(messages) - set(after["links"].get(link, ())):
            yield f"{link}: {gone} was removed"
    for name, had in before["methods"].items():
        has = after["methods"].get(name)
        if has is None:
            yield f"method {name} was removed"
        elif list(had.items()) != list(has.items()):
            yield f"method {name} has other arguments, or another result"
    yield from breaks_of_types(before["types"], after["types"])


def breaks_of_types(before: Schema, after: Schema) -> Iterator[str]:
    """Yield the changes of types, by name, that keep one side from reading what the other one writes."""
    for name, part in before.items():
        now = after.get(name)
        if now is not None and now != part:
            yield from (f"{name}: {why}" for why in _changes(part, now))


def _changes(had: Schema, has: Schema) -> Iterator[str]:
    old, new = had.get("properties"), has.get("properties")
    if old is None or new is None:
        yield "it is another type"
        return
    needed_before, needed_now = set(had.get("required", ())), set(has.get("required", ()))
    for field in needed_now - needed_before:
        yield f"field {field} has no default"
    for field in needed_before - new.keys():
        yield f"field {field}, which has no default in the release before, was removed"
    if had.get("additionalProperties") is False:
        for field in new.keys() - old.keys():
            yield f"field {field} is unknown to the release before, which refuses unknown fields"
    for field in old.keys() & new.keys():
        if {**old[field], "default": None} != {**new[field], "default": None}:
            yield f"field {field} is of another type"


# -- samples -----------------------------------------------------------------------------------------------------------


def samples() -> dict[str, dict[str, str]]:
    """Return a sample of each message of each link, as MessagePack in hexadecimal."""
    return {
        name: {one.__name__: msgspec.msgpack.encode(sample(one)).hex() for one in structs_of(link)}
        for name, link in LINKS.items()
    }


def sample(kind: Any) -> Any:
    """Return a value of a type, with all fields set."""
    return _sample(msgspec.inspect.type_info(kind))


def _sample(info: Any) -> Any:  # noqa: PLR0911 - one line a kind
    match info:
        case (
            msgspec.inspect.StructType(cls=cls, fields=fields)
            | msgspec.inspect.DataclassType(cls=cls, fields=fields)
            | msgspec.inspect.NamedTupleType(cls=cls, fields=fields)
        ):
            return _instance(cls, fields)
        case msgspec.inspect.UnionType(types=types):
            return _sample(next(one for one in types if not isinstance(one, msgspec.inspect.NoneType)))
        case msgspec.inspect.ListType(item_type=item) | msgspec.inspect.VarTupleType(item_type=item):
            return [_sample(item)] if isinstance(info, msgspec.inspect.ListType) else (_sample(item),)
        case msgspec.inspect.TupleType(item_types=items):
            return tuple(map(_sample, items))
        case msgspec.inspect.DictType(key_type=key, value_type=value):
            return {_sample(key): _sample(value)}
        case msgspec.inspect.LiteralType(values=values):
            return values[0]
        case msgspec.inspect.EnumType(cls=cls):
            return next(iter(cls))
        case msgspec.inspect.Metadata(type=annotated):
            return _sample(annotated)
        case msgspec.inspect.RawType():
            return msgspec.Raw(msgspec.msgpack.encode(None))
        case _:
            return _PLAIN[type(info).__name__]


def _instance(cls: type, fields: Iterable[msgspec.inspect.Field]) -> Any:
    """Return an instance with all fields set, or with those that must be if it checks the values of others."""
    if cls in EXAMPLES:
        return EXAMPLES[cls]
    try:
        return cls(**{field.name: _sample(field.type) for field in fields})
    except PPaaSError:
        return cls(**{field.name: _sample(field.type) for field in fields if field.required})


EXAMPLES: dict[type, Any] = {PinholeCamera: PinholeCamera(width=640, height=480, fx=525.0, cx=319.5, cy=239.5)}
"""Instances of types that check all their fields."""

_PLAIN: dict[str, Any] = {
    "IntType": 1, "FloatType": 0.5, "BoolType": True, "StrType": "a", "BytesType": b"\x01", "AnyType": 1,
    "NoneType": None,
}  # fmt: skip


def encoded(value: Any) -> str:
    """Return JSON with one line for each message, method and type."""
    parts = []
    for key, members in value.items():
        lines = [f"  {_json(name)}: {_json(member)}" for name, member in members.items()]
        parts.append(f" {_json(key)}: {{\n" + ",\n".join(lines) + "\n }")
    return "{\n" + ",\n".join(parts) + "\n}\n"


def _json(value: Any) -> str:
    return msgspec.json.encode(value).decode()


if __name__ == "__main__":
    (FOLDER / f"schema-{OWN.newest}.json").write_text(encoded(schema()))
    (FOLDER / f"samples-{OWN.newest}.json").write_text(encoded(samples()))
