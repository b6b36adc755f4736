"""A connection that goes nowhere, for what waits to be sent."""

from endpoints.rosbridge.outbox import FrameOutbox


class Connection:
    """Takes so many frames, then no more."""

    def __init__(self, room: float = float("inf")) -> None:
        self.sent: list[str] = []
        self.room = room

    @property
    def ready(self) -> bool:
        return len(self.sent) < self.room

    def send_frame(self, frame: bytes) -> None:
        assert self.ready, "frames are sent only while the connection takes them"
        self.sent.append(frame.decode())


def sent(outbox: FrameOutbox, count: float = float("inf")) -> list[str]:
    """Return what a connection is sent that takes so many frames; then it is gone."""
    connection = Connection(count)
    outbox.connect(connection)
    outbox.connect(None)
    return connection.sent
