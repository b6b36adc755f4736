"""Frames that are sent to a client as binary messages of its WebSocket."""


class BinaryFrame(bytes):
    """Content of a binary message; a frame that is plain ``bytes`` is text in UTF-8."""

    __slots__ = ()
