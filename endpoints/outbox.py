"""What waits to be sent to one client: bounded by topic, so that a slow reader costs nobody but itself."""

import asyncio
import itertools
from collections import OrderedDict, defaultdict, deque
from dataclasses import dataclass

from ppaas.clock import Clock, monotonic
from ppaas.errors import Unavailable

DEFAULT_KEEP = 10
KEEP = {"cmd_vel": 1, "scan": 1, "odom": 1, "map": 1, "plan": 1, "particlecloud": 1, "tf": 50, "move_base/result": 1000}
"""Messages of a topic that wait, if the client did not say; the newest are kept."""

MAX_KEEP = 1000

EXPIRY = {"cmd_vel": 0.5}
"""Seconds after which a message of a topic is worse than none: an old command must not move a robot."""


@dataclass(frozen=True, slots=True)
class _Entry:
    frame: str
    expires: float


class Outbox:
    """Frames on their way to one client, in the order in which they came.

    Parameters
    ----------
    clock : callable
        Monotonic seconds.
    """

    def __init__(self, clock: Clock = monotonic) -> None:
        self._clock = clock
        self._numbers = itertools.count()
        self._entries: OrderedDict[int, _Entry] = OrderedDict()
        self._by_topic: defaultdict[str, deque[int]] = defaultdict(deque)
        self._wake = asyncio.Event()

    def __len__(self) -> int:
        """Return how many frames wait."""
        return len(self._entries)

    def put(self, topic: str, frame: str, keep: int) -> None:
        """Add a frame of a topic; of more than ``keep`` the oldest is dropped."""
        waiting = self._by_topic[topic]
        while waiting and (waiting[0] not in self._entries or len(waiting) >= min(max(keep, 1), MAX_KEEP)):
            self._entries.pop(waiting.popleft(), None)
        waiting.append(self._add(_Entry(frame, self._clock() + EXPIRY.get(topic, float("inf")))))

    def put_answer(self, frame: str) -> None:
        """Add a frame that must not be dropped: a response, or a status.

        Raises
        ------
        Unavailable
            The client reads too slowly to be served.
        """
        if len(self._entries) >= 10 * MAX_KEEP:
            raise Unavailable("the client asks faster than it reads the answers")
        self._add(_Entry(frame, float("inf")))

    def _add(self, entry: _Entry) -> int:
        number = next(self._numbers)
        self._entries[number] = entry
        self._wake.set()
        return number

    async def get(self) -> str:
        """Return the next frame that has neither been dropped nor expired; wait if there is none."""
        while True:
            while self._entries:
                _, entry = self._entries.popitem(last=False)
                if self._clock() < entry.expires:
                    return entry.frame
            self._wake.clear()
            await self._wake.wait()
