"""Page of the messages: the fields of each type that topics and services have."""

from collections.abc import Iterable, Sequence

from docs.site.reference.clones import members
from docs.site.reference.markdown import code, slug, table
from docs.site.reference.markdown import page as joined
from ppaas.messages import Message
from ppaas.messages.base.message import NO_ARRAY
from ppaas.messages.base.rosapi import TypeDef
from ppaas.wire.typedefs import ANY_LENGTH, typedefs

INTRODUCTION = """
Fields of the types that [topics and services](topics.md) have. Names and fields are those of ROS 1; `header.seq` is
there too, and a time is `secs` and `nsecs`. Clients may write types and times as in ROS 2.
"""


def page() -> str:
    """Return the page."""
    found = members()
    topics = (topic.type for member in found for topic in member.topics.values())
    messages = {each.type: each for kind in dict.fromkeys(topics) for each in typedefs(kind)}
    services = {service.type.name: service for member in found for service in member.node.services}
    for service in services.values():
        for kind in (service.type.request, service.type.response):
            messages |= {definition.type: definition for definition in typedefs(kind)[1:]}
    sections = [part for name in sorted(messages) for part in (f"### {code(name)}", _fields(messages[name], messages))]
    calls = [
        part
        for name, service in sorted(services.items())
        for part in (
            f"### {code(name)}",
            *_half("request", service.type.request, messages),
            *_half("response", service.type.response, messages),
        )
    ]
    return joined("# Messages", INTRODUCTION, "## Messages of topics", *sections, "## Services", *calls)


def _half(what: str, kind: type[Message], known: dict[str, TypeDef]) -> Sequence[str]:
    definition = typedefs(kind)[0]
    return (f"*{what.capitalize()}:*" + ("" if definition.fieldnames else " empty"), _fields(definition, known))


def _fields(definition: TypeDef, known: dict[str, TypeDef]) -> str:
    rows = [
        (code(name), _type(kind, known) + _array(length), "")
        for name, kind, length in zip(
            definition.fieldnames, definition.fieldtypes, definition.fieldarraylen, strict=True
        )
    ]
    constants = zip(definition.constnames, definition.constvalues, strict=True)
    rows += [(code(name), "constant", value) for name, value in constants]
    return table(("field", "type", "value"), rows) if definition.constnames else _plain(rows)


def _plain(rows: Iterable[Sequence[str]]) -> str:
    return table(("field", "type"), (row[:2] for row in rows))


def _type(kind: str, known: dict[str, TypeDef]) -> str:
    return f"[{code(kind)}](#{slug(kind)})" if kind in known else code(kind)


def _array(length: int) -> str:
    return {NO_ARRAY: "", ANY_LENGTH: " []"}.get(length, f" [{length}]")
