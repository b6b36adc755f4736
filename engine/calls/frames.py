"""Frames of calls: a method and its arguments, the result or the error, and notices without an answer."""

import msgspec

from engine.protocols.refusals import Refusal


class Call(msgspec.Struct, tag="call"):
    """Call of a method; ``arguments`` is an array of MessagePack."""

    number: int
    method: str
    arguments: msgspec.Raw


class Notice(msgspec.Struct, tag="notice"):
    """Call of a method without an answer."""

    method: str
    arguments: msgspec.Raw


class Result(msgspec.Struct, tag="result"):
    """Result of a call, as MessagePack."""

    number: int
    value: msgspec.Raw


class Failure(msgspec.Struct, tag="failure"):
    """Error of a call."""

    number: int
    refusal: Refusal


Frame = Call | Notice | Result | Failure
