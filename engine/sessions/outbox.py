"""Outbox of one client: frames waiting to be sent, bounded per topic and in total, so that a slow reader harms nobody.

It outlives the socket. To a client that reconnects and reports how many frames it received, the frames that must
arrive and did not are sent again; see ``docs/design-sessions.md``. In the container, its connection is a socket at the
other end of the link to an endpoint.
"""

import itertools
from collections import OrderedDict, defaultdict, deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import NamedTuple

from engine.links.frame_writer import FrameSink, FrameWriter
from engine.protocols.session_frames import SessionFromContainer, SocketFrame
from ppaas.clock import Clock, monotonic
from ppaas.errors import Unavailable
from ppaas.nodes.topics import policy_of
from ppaas.wire.binary.binary_frame import BinaryFrame
from ppaas.wire.fragments import in_fragments

MAX_KEEP = 1000
"""Largest queue length of a topic; a tenth of the frames that may wait in total."""

MAX_BYTES = 16 << 20
"""Largest size of the waiting frames [bytes]. Beyond it the oldest frames of topics that are not lasting are dropped;
a client with more than that in frames that must not be dropped is disconnected."""

MAX_SENT = 256
"""Largest number of sent frames that are kept to be sent again."""

MAX_SENT_BYTES = 4 << 20
"""Largest size of sent frames that are kept [bytes]; a single larger frame is not kept."""


MOST_CONNECTS = 16
"""Largest number of connections whose times are kept."""


Sent = Callable[[], None]
"""Called once when a frame is sent, before its connection gets it."""


class _QueuedMessage(NamedTuple):
    frame: bytes
    expires: float
    lasts: bool
    fragment_size: int = 0
    sent: Sent | None = None


class FrameOutbox:
    """Frames to one client in order of arrival, sent at once if the connection is ready.

    Parameters
    ----------
    clock : callable
        Returns monotonic time [s].

    Attributes
    ----------
    count : int
        Number of frames that were sent.
    repeats : bool
        Whether sent frames that must arrive are kept for ``resume``.
    dropped : int
        Messages that were dropped because the client reads too slowly.
    dropped_at : float
        Time of the last one [s].
    connected_at : deque of float
        Times of the last connections [s].
    """

    def __init__(self, clock: Clock = monotonic) -> None:
        self._clock = clock
        self._numbers = itertools.count()
        self._entries: OrderedDict[int, _QueuedMessage] = OrderedDict()
        self._bytes = 0
        self._by_topic: defaultdict[str, deque[int]] = defaultdict(deque)
        self._urgent: deque[int] = deque()
        self._parts: deque[_QueuedMessage] = deque()
        self._whole: _QueuedMessage | None = None
        self._fragmented = itertools.count(1)
        self._sink: FrameSink | None = None
        self.count = 0
        self._sent: deque[tuple[int, _QueuedMessage]] = deque()
        self._sent_bytes = 0
        self.repeats = False
        self._corks = 0
        self.dropped, self.dropped_at = 0, float("-inf")
        self.connected_at: deque[float] = deque(maxlen=MOST_CONNECTS)

    def __len__(self) -> int:
        """Return the number of waiting frames."""
        return len(self._entries) + len(self._parts)

    @property
    def connected(self) -> bool:
        """Whether there is a connection now."""
        return self._sink is not None

    # -- waiting frames ------------------------------------------------------------------------------------------------

    def put(self, topic: str, frame: bytes, keep: int, fragment_size: int = 0) -> None:
        """Add a frame of a topic; beyond ``keep`` waiting frames of it, the oldest is dropped.

        One of an urgent topic is sent before all that wait, but those of urgent topics.
        It is sent in fragments if it has more than ``fragment_size`` characters, unless that is 0.
        """
        waiting = self._by_topic[topic]
        while waiting and (waiting[0] not in self._entries or len(waiting) >= min(max(keep, 1), MAX_KEEP)):
            self._drop(waiting.popleft())
        policy = policy_of(topic)
        entry = _QueuedMessage(frame, self._clock() + policy.expiry, policy.lasting, fragment_size)
        waiting.append(self._add(entry, urgent=policy.urgent))

    def put_answer(self, frame: bytes, fragment_size: int = 0, sent: Sent | None = None) -> None:
        """Add a frame that must not be dropped: a response, or a status; for ``fragment_size`` see ``put``.

        ``sent`` is called once when the frame is sent.

        Raises
        ------
        Unavailable
            Too many responses wait: the client reads too slowly.
        """
        if len(self._entries) >= 10 * MAX_KEEP or self._bytes >= MAX_BYTES:
            self._make_room()
            if len(self._entries) >= 10 * MAX_KEEP or self._bytes >= MAX_BYTES:
                raise Unavailable("the client sends requests faster than it reads the responses")
        self._add(_QueuedMessage(frame, float("inf"), True, fragment_size, sent))

    def _add(self, entry: _QueuedMessage, *, urgent: bool = False) -> int:
        number = next(self._numbers)
        self._entries[number] = entry
        if urgent:
            self._urgent.append(number)
        self._bytes += len(entry.frame)
        self.flush()
        if self._bytes > MAX_BYTES:
            self._make_room(number)
        return number

    def _drop(self, number: int) -> None:
        entry = self._entries.pop(number, None)
        if entry is not None:
            if number in self._urgent:
                self._urgent.remove(number)
            if self._sink is not None:
                self.dropped, self.dropped_at = self.dropped + 1, self._clock()
            self._bytes -= len(entry.frame)

    def _make_room(self, newest: int | None = None) -> None:
        for number in [n for n, entry in self._entries.items() if not entry.lasts and n != newest]:
            if self._bytes < MAX_BYTES:
                return
            self._drop(number)

    # -- sending --------------------------------------------------------------------------------------------------

    def connect(self, sink: FrameSink | None) -> None:
        """Send through a connection from now on, starting with the waiting frames; with None, let all frames wait.

        A message of which only some fragments were sent is sent again, unless its client counts the frames.
        """
        if self._parts and self._whole is not None and not self.repeats:
            self._parts.clear()
            self._put_first(self._whole)
        self._sink = sink
        if sink is not None:
            self.connected_at.append(self._clock())
        self.flush()

    @contextmanager
    def corked(self) -> Iterator[None]:
        """Let frames wait meanwhile, and send them afterwards."""
        self._corks += 1
        try:
            yield
        finally:
            self._corks -= 1
            self.flush()

    def flush(self) -> None:
        """Send waiting frames while the connection is ready; expired frames are skipped."""
        sink = None if self._corks else self._sink
        while sink is not None and sink.ready and (self._parts or self._entries):
            if self._urgent:
                self._send_urgent(sink)
            elif self._parts:
                self._send(sink, self._parts.popleft())
            else:
                self._take_next()

    def _send_urgent(self, sink: FrameSink) -> None:
        """Send the next urgent frame whole, also between the fragments of another, unless it is expired."""
        entry = self._entries.pop(self._urgent.popleft())
        self._bytes -= len(entry.frame)
        if self._clock() < entry.expires:
            self._send(sink, entry)

    def _send(self, sink: FrameSink, entry: _QueuedMessage) -> None:
        self._note_sent(entry)
        if entry.sent is not None:
            entry.sent()
        sink.send_frame(entry.frame)

    def _take_next(self) -> None:
        """Make the next waiting frame, unless it is expired, the one to send, in its fragments."""
        _, entry = self._entries.popitem(last=False)
        self._bytes -= len(entry.frame)
        if self._clock() < entry.expires:
            frames = in_fragments(entry.frame, entry.fragment_size, f"ppaas-{next(self._fragmented)}")
            self._parts.extend(_QueuedMessage(frame, entry.expires, entry.lasts) for frame in frames[:-1])
            self._parts.append(_QueuedMessage(frames[-1], entry.expires, entry.lasts, sent=entry.sent))
            self._whole = entry if len(frames) > 1 else None

    def _note_sent(self, entry: _QueuedMessage) -> None:
        self.count += 1
        if self.repeats and entry.lasts and len(entry.frame) <= MAX_SENT_BYTES:
            self._sent.append((self.count, entry._replace(sent=None)))
            self._sent_bytes += len(entry.frame)
            while len(self._sent) > MAX_SENT or self._sent_bytes > MAX_SENT_BYTES:
                self._sent_bytes -= len(self._sent.popleft()[1].frame)

    def resume(self, received: int) -> None:
        """Queue again, before all others, the kept frames that a client did not receive.

        Parameters
        ----------
        received : int
            Number of frames that it received since its session began.
        """
        self.count = received
        while self._parts:
            self._put_first(self._parts.pop())
        while self._sent and self._sent[-1][0] > received:
            _, entry = self._sent.pop()
            self._sent_bytes -= len(entry.frame)
            self._put_first(entry)

    def _put_first(self, entry: _QueuedMessage) -> None:
        number = next(self._numbers)
        self._entries[number] = entry
        self._entries.move_to_end(number, last=False)
        self._bytes += len(entry.frame)


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
    take_settled : callable
        Returns the numbers of the frames of the client that were settled since the last call.
    """

    def __init__(self, link: EndpointEnd, socket: int, take_settled: Callable[[], list[int]]) -> None:
        self.link = link
        self.socket = socket
        self._take_settled = take_settled
        self.reads = True
        """Whether the client reads fast enough."""

    @property
    def ready(self) -> bool:
        """Whether a frame can be sent now."""
        return self.reads and self.link.waiting <= MAX_WAITING

    def send_frame(self, frame: bytes) -> None:
        """Send a frame."""
        settled = tuple(self._take_settled())
        self.link.write(SocketFrame(self.socket, bytes(frame), isinstance(frame, BinaryFrame), settled))
