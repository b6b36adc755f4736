"""Fragments of frames: frames of clients are put together from them, and long ones for clients are cut into them.

Source: section 3.1.1 of ``ROSBRIDGE_PROTOCOL.md`` of ``RobotWebTools/rosbridge_suite``.
"""

from collections.abc import Collection
from dataclasses import dataclass, field

import msgspec

from ppaas.errors import InvalidInput, QuotaExceeded
from ppaas.wire.binary.binary_frame import BinaryFrame
from ppaas.wire.operations import CallService, Fragment, Id, Subscribe

MAX_OPEN = 16
"""Largest number of incomplete frames of one client; beyond it, the oldest is dropped."""

MAX_SIZE = 16 << 20
"""Largest size of all fragments that one client has sent of incomplete frames [characters]."""

MAX_FRAGMENTS = 1 << 16
"""Largest number of fragments of one frame."""


LEAST_SIZE = 1024
"""Least length of the fragments of a frame: frames of shorter ones would be mostly envelopes [characters]."""

MOST_PARTS = 1000
"""Largest number of fragments in which a frame is sent to a client."""

_encoder = msgspec.json.Encoder()


def size_of(operation: Subscribe | CallService) -> int:
    """Return the size from which messages for an operation are sent in fragments [characters]; 0 for never."""
    return max(int(operation.fragment_size or 0), 0)


def in_fragments(frame: bytes, size: int, identity: str) -> list[bytes]:
    """Return a frame as frames of its fragments, or itself if it is short enough, binary, or the size is 0.

    Parameters
    ----------
    frame : bytes
        Text of the frame in UTF-8, or a binary frame.
    size : int
        Length of a fragment [characters], of which `LEAST_SIZE` is used at least.
    identity : str
        Id of the fragments.
    """
    size = max(size, LEAST_SIZE) if size and not isinstance(frame, BinaryFrame) else len(frame)
    text = frame.decode() if len(frame) > size else ""
    if len(text) <= size:
        return [frame]
    size = max(size, -(-len(text) // MOST_PARTS))
    pieces = [text[begin : begin + size] for begin in range(0, len(text), size)]
    return [_encoder.encode(Fragment(piece, n, len(pieces), identity)) for n, piece in enumerate(pieces)]


@dataclass(slots=True)
class _Incomplete:
    total: int
    parts: dict[int, str] = field(default_factory=dict)
    size: int = 0


class FragmentAssembler:
    """Incomplete frames of one client, by their ids."""

    def __init__(self) -> None:
        self._open: dict[Id, _Incomplete] = {}

    @property
    def incomplete(self) -> Collection[Id]:
        """Ids of the incomplete frames."""
        return self._open.keys()

    def add(self, fragment: Fragment) -> str | None:
        """Add a fragment; return the frame if that completes it.

        Raises
        ------
        InvalidInput
            The fragment has no id, its number is not below ``total``, or ``total`` differs from the others'.
        QuotaExceeded
            The incomplete frames of the client are too large.
        """
        if fragment.id is None:
            raise InvalidInput("a fragment needs the id of its frame")
        if not 0 <= fragment.num < fragment.total <= MAX_FRAGMENTS:
            raise InvalidInput(f"fragments of a frame are numbered from 0 to total - 1, up to {MAX_FRAGMENTS - 1}")
        frame = self._open.setdefault(fragment.id, _Incomplete(fragment.total))
        if frame.total != fragment.total:
            del self._open[fragment.id]
            raise InvalidInput("fragments of one frame must have the same total: send the frame again")
        self._put(frame, fragment)
        if len(frame.parts) < frame.total:
            return None
        del self._open[fragment.id]
        return "".join(frame.parts[number] for number in range(frame.total))

    def _put(self, frame: _Incomplete, fragment: Fragment) -> None:
        size = len(fragment.data) - len(frame.parts.get(fragment.num, ""))
        if sum(each.size for each in self._open.values()) + size > MAX_SIZE:
            self._open.clear()
            raise QuotaExceeded(f"fragments of incomplete frames may have {MAX_SIZE >> 20} MiB: send the frames again")
        frame.parts[fragment.num] = fragment.data
        frame.size += size
        if len(self._open) > MAX_OPEN:
            del self._open[next(iter(self._open))]
