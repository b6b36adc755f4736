"""Fake connection of an outbox."""

from engine.sessions.outbox import FrameOutbox

BINARY = "surrogateescape"
"""Handler of errors by which binary frames are strings, too: ``encode(errors=BINARY)`` returns their bytes."""


class Connection:
    """Accepts ``room`` frames and then blocks."""

    def __init__(self, room: float = float("inf")) -> None:
        self.sent: list[str] = []
        self.room = room

    @property
    def ready(self) -> bool:
        return len(self.sent) < self.room

    def send_frame(self, frame: bytes) -> None:
        assert self.ready, "frames are sent only while the connection is ready"
        self.sent.append(frame.decode(errors=BINARY))


def sent(outbox: FrameOutbox, count: float = float("inf")) -> list[str]:
    """Return the frames sent to a connection that accepts ``count`` frames and is then lost."""
    connection = Connection(count)
    outbox.connect(connection)
    outbox.connect(None)
    return connection.sent
