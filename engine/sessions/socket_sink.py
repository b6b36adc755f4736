"""Socket of a client, as the container sees it: at the other end of the link to an endpoint."""

from engine.links.frame_writer import FrameWriter
from engine.protocols.session_frames import SessionFromContainer, SocketFrame
from engine.sessions.unsettled import UnsettledFrames
from ppaas.wire.binary.binary_frame import BinaryFrame

MAX_WAITING = 1 << 20
"""Bytes that wait on the link of an endpoint above which its sockets get no further frames."""


EndpointEnd = FrameWriter[SessionFromContainer]
"""Link to an endpoint."""


class SocketSink:
    """Sends the frames of an outbox to a socket, with the frames of the client that are settled meanwhile.

    Parameters
    ----------
    link : EndpointEnd
        Link to the endpoint that has the socket.
    socket : int
        Number of the socket on the link.
    unsettled : UnsettledFrames
        Frames of the client.
    """

    def __init__(self, link: EndpointEnd, socket: int, unsettled: UnsettledFrames) -> None:
        self.link = link
        self.socket = socket
        self._unsettled = unsettled
        self.reads = True
        """Whether the client reads fast enough."""

    @property
    def ready(self) -> bool:
        """Whether a frame can be sent now."""
        return self.reads and self.link.waiting <= MAX_WAITING

    def send_frame(self, frame: bytes) -> None:
        """Send a frame."""
        settled = tuple(self._unsettled.take_settled())
        self.link.write(SocketFrame(self.socket, bytes(frame), isinstance(frame, BinaryFrame), settled))
