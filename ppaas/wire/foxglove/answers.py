"""Answers of a server of Foxglove's protocol: operations as JSON; messages, times and results as binary frames."""

import struct
from collections.abc import Iterable, Mapping, Sequence
from enum import IntEnum
from typing import Any, Final, NamedTuple

import msgspec

from ppaas.wire.binary.binary_frame import BinaryFrame
from ppaas.wire.foxglove.requests import Parameter

CAPABILITIES: Final = (
    "clientPublish", "time", "parameters", "parametersSubscribe", "services", "connectionGraph",
)  # fmt: skip
"""Capabilities that the server declares."""

ENCODINGS: Final = ("json", "cdr", "ros1")
"""Encodings that clients may publish and call in."""

_MESSAGE = struct.Struct("<BIQ")
_TIME = struct.Struct("<BQ")
_CALL = struct.Struct("<BIII")
_ASSET = struct.Struct("<BIBI")

_MESSAGE_DATA, _TIME_DATA, _SERVICE_RESPONSE, _FETCH_RESPONSE = 1, 2, 3, 4
_FETCH_FAILED = 1

_encoder = msgspec.json.Encoder()


class Level(IntEnum):
    """Level of a status."""

    INFO = 0
    WARNING = 1
    ERROR = 2


class Schema(NamedTuple):
    """Encoding of messages, and the schema that they have.

    ``data`` is text, or the schema's bytes as base64.
    """

    encoding: str
    name: str
    schema_encoding: str
    data: str


class Channel(NamedTuple):
    """Channel of the server."""

    id: int
    topic: str
    schema: Schema


class FoxgloveService(NamedTuple):
    """Service of the server; requests and responses are JSON."""

    id: int
    name: str
    type: str
    request: Schema
    response: Schema


def server_info(name: str, session: str) -> bytes:
    """Return the first answer: name of the server and of the session, and the capabilities."""
    return _encoder.encode(
        {
            "op": "serverInfo",
            "name": name,
            "capabilities": CAPABILITIES,
            "supportedEncodings": ENCODINGS,
            "metadata": {},
            "sessionId": session,
        }
    )


def status(level: Level, message: str, status_id: str | None = None) -> bytes:
    """Return a text for the user; one with an id replaces the one before, and can be removed."""
    fields: dict[str, Any] = {"op": "status", "level": int(level), "message": message}
    return _encoder.encode(fields if status_id is None else fields | {"id": status_id})


def remove_status(status_ids: Sequence[str]) -> bytes:
    """Return the removal of texts."""
    return _encoder.encode({"op": "removeStatus", "statusIds": status_ids})


def advertise(channels: Iterable[Channel]) -> bytes:
    """Return the announcement of channels."""
    listed = [
        {
            "id": channel.id,
            "topic": channel.topic,
            "encoding": channel.schema.encoding,
            "schemaName": channel.schema.name,
            "schema": channel.schema.data,
            "schemaEncoding": channel.schema.schema_encoding,
        }
        for channel in channels
    ]
    return _encoder.encode({"op": "advertise", "channels": listed})


def unadvertise(channel_ids: Sequence[int]) -> bytes:
    """Return the end of channels."""
    return _encoder.encode({"op": "unadvertise", "channelIds": channel_ids})


def advertise_services(services: Iterable[FoxgloveService]) -> bytes:
    """Return the announcement of services."""
    listed = [
        {
            "id": service.id,
            "name": service.name,
            "type": service.type,
            "request": _described(service.request),
            "response": _described(service.response),
        }
        for service in services
    ]
    return _encoder.encode({"op": "advertiseServices", "services": listed})


def _described(schema: Schema) -> dict[str, str]:
    return {
        "encoding": schema.encoding,
        "schemaName": schema.name,
        "schemaEncoding": schema.schema_encoding,
        "schema": schema.data,
    }


def unadvertise_services(service_ids: Sequence[int]) -> bytes:
    """Return the end of services."""
    return _encoder.encode({"op": "unadvertiseServices", "serviceIds": service_ids})


def parameter_values(parameters: Sequence[Parameter], request_id: str | None = None) -> bytes:
    """Return values of parameters."""
    fields: dict[str, Any] = {"op": "parameterValues", "parameters": parameters}
    return _encoder.encode(fields if request_id is None else fields | {"id": request_id})


def service_failed(service_id: int, call_id: int, message: str) -> bytes:
    """Return the failure of a call."""
    return _encoder.encode({"op": "serviceCallFailure", "serviceId": service_id, "callId": call_id, "message": message})


class ConnectionGraph(NamedTuple):
    """Names of nodes by the topics that they publish or subscribe to, and by the services that they offer."""

    published: Mapping[str, Sequence[str]]
    subscribed: Mapping[str, Sequence[str]]
    services: Mapping[str, Sequence[str]]

    def changes_to(self, later: "ConnectionGraph") -> bytes | None:
        """Return the answer that turns this graph into a later one; None if they are equal."""
        if self == later:
            return None
        topics = set(later.published) | set(later.subscribed)
        return _encoder.encode(
            {
                "op": "connectionGraphUpdate",
                "publishedTopics": _listed(self.published, later.published, "publisherIds"),
                "subscribedTopics": _listed(self.subscribed, later.subscribed, "subscriberIds"),
                "advertisedServices": _listed(self.services, later.services, "providerIds"),
                "removedTopics": sorted((set(self.published) | set(self.subscribed)) - topics),
                "removedServices": sorted(set(self.services) - set(later.services)),
            }
        )


def _listed(
    before: Mapping[str, Sequence[str]], after: Mapping[str, Sequence[str]], key: str
) -> list[dict[str, str | list[str]]]:
    gone = {name: () for name in before if name not in after}
    return [{"name": name, key: list(nodes)} for name, nodes in {**after, **gone}.items() if before.get(name) != nodes]


def message_data(subscription: int, time: int, data: bytes) -> BinaryFrame:
    """Return a message for a subscription, received at a time [ns since the epoch]."""
    return BinaryFrame(_MESSAGE.pack(_MESSAGE_DATA, subscription, time) + data)


def time_data(time: int) -> BinaryFrame:
    """Return the time of the server [ns since the epoch]."""
    return BinaryFrame(_TIME.pack(_TIME_DATA, time))


def service_response(service_id: int, call_id: int, encoding: str, data: bytes) -> BinaryFrame:
    """Return the result of a call."""
    named = encoding.encode()
    return BinaryFrame(_CALL.pack(_SERVICE_RESPONSE, service_id, call_id, len(named)) + named + data)


def asset_failed(request_id: int, message: str) -> BinaryFrame:
    """Return the failure to fetch a file."""
    text = message.encode()
    return BinaryFrame(_ASSET.pack(_FETCH_RESPONSE, request_id, _FETCH_FAILED, len(text)) + text)
