"""What waits to be sent to one client: bounded by topic and in all, so that a slow reader costs nobody but itself.

It outlives the socket. A client that comes back and says how many frames it received is sent again what must arrive
and did not; see ``docs/adr/0013-sessions-outlive-sockets.md``.
"""

import itertools
from collections import OrderedDict, defaultdict, deque
from typing import NamedTuple, Protocol

from ppaas.clock import Clock, monotonic
from ppaas.errors import Unavailable
from ppaas.nodes.topics import policy_of

MAX_KEEP = 1000

MAX_BYTES = 16 << 20
"""Bytes of frames that wait. Beyond it the oldest messages of all topics that do not last are dropped first; a
client for which so much waits that must not be dropped is closed."""

MAX_SENT = 256
MAX_SENT_BYTES = 4 << 20
"""Frames, and bytes of them, that were sent and are kept to be sent again; a larger frame is not."""


class Sink(Protocol):
    """A connection that frames are sent through."""

    @property
    def ready(self) -> bool:
        """Whether it takes a frame now."""
        ...

    def send_frame(self, frame: bytes) -> None:
        """Send a frame; only while ready."""
        ...


class _Entry(NamedTuple):
    frame: bytes
    expires: float
    lasts: bool


class Outbox:
    """Frames on their way to one client, in the order in which they came; sent at once where that is possible.

    Parameters
    ----------
    clock : callable
        Monotonic seconds.

    Attributes
    ----------
    repeats : bool
        Keep what was sent and lasts, for ``resume``.
    """

    def __init__(self, clock: Clock = monotonic) -> None:
        self._clock = clock
        self._numbers = itertools.count()
        self._entries: OrderedDict[int, _Entry] = OrderedDict()
        self._bytes = 0
        self._by_topic: defaultdict[str, deque[int]] = defaultdict(deque)
        self._sink: Sink | None = None
        self._count = 0
        self._sent: deque[tuple[int, _Entry]] = deque()
        self._sent_bytes = 0
        self.repeats = False

    def __len__(self) -> int:
        """Return how many frames wait."""
        return len(self._entries)

    # -- what waits ----------------------------------------------------------------------------------------------------

    def put(self, topic: str, frame: bytes, keep: int) -> None:
        """Add a frame of a topic; of more than ``keep`` the oldest is dropped."""
        waiting = self._by_topic[topic]
        while waiting and (waiting[0] not in self._entries or len(waiting) >= min(max(keep, 1), MAX_KEEP)):
            self._drop(waiting.popleft())
        policy = policy_of(topic)
        waiting.append(self._add(_Entry(frame, self._clock() + policy.expiry, policy.lasting)))

    def put_answer(self, frame: bytes) -> None:
        """Add a frame that must not be dropped: a response, or a status.

        Raises
        ------
        Unavailable
            The client reads too slowly to be served.
        """
        if len(self._entries) >= 10 * MAX_KEEP or self._bytes >= MAX_BYTES:
            self._make_room()
            if len(self._entries) >= 10 * MAX_KEEP or self._bytes >= MAX_BYTES:
                raise Unavailable("the client asks faster than it reads the answers")
        self._add(_Entry(frame, float("inf"), True))

    def _add(self, entry: _Entry) -> int:
        number = next(self._numbers)
        self._entries[number] = entry
        self._bytes += len(entry.frame)
        self.flush()
        if self._bytes > MAX_BYTES:
            self._make_room(number)
        return number

    def _drop(self, number: int) -> None:
        entry = self._entries.pop(number, None)
        if entry is not None:
            self._bytes -= len(entry.frame)

    def _make_room(self, newest: int | None = None) -> None:
        for number in [n for n, entry in self._entries.items() if not entry.lasts and n != newest]:
            if self._bytes < MAX_BYTES:
                return
            self._drop(number)

    # -- what is sent --------------------------------------------------------------------------------------------------

    def connect(self, sink: Sink | None) -> None:
        """Send through a connection from now on, what waits first; with None, let all wait."""
        self._sink = sink
        self.flush()

    def flush(self) -> None:
        """Send what waits, while the connection takes it; what has expired meanwhile is left out."""
        sink = self._sink
        while sink is not None and self._entries and sink.ready:
            _, entry = self._entries.popitem(last=False)
            self._bytes -= len(entry.frame)
            if self._clock() < entry.expires:
                self._note_sent(entry)
                sink.send_frame(entry.frame)

    def _note_sent(self, entry: _Entry) -> None:
        self._count += 1
        if self.repeats and entry.lasts and len(entry.frame) <= MAX_SENT_BYTES:
            self._sent.append((self._count, entry))
            self._sent_bytes += len(entry.frame)
            while len(self._sent) > MAX_SENT or self._sent_bytes > MAX_SENT_BYTES:
                self._sent_bytes -= len(self._sent.popleft()[1].frame)

    def resume(self, received: int) -> None:
        """Send again, before all else, what lasts of the frames that a client did not receive.

        Parameters
        ----------
        received : int
            Frames that it received since its session began.
        """
        self._count = received
        while self._sent and self._sent[-1][0] > received:
            _, entry = self._sent.pop()
            self._sent_bytes -= len(entry.frame)
            self._put_first(entry)

    def _put_first(self, entry: _Entry) -> None:
        number = next(self._numbers)
        self._entries[number] = entry
        self._entries.move_to_end(number, last=False)
        self._bytes += len(entry.frame)
