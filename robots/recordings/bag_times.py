"""Times of the messages of a bag: stamps that its robot did not set, and clocks that were set back."""

from collections import defaultdict
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

SET_BACK = 1.0
"""Time by which a stamp is before the newest of its frame from which on the robot's clock was set back [s]."""

APART = 60.0
"""Time between all scans and all odometry from which on their clocks differ [s]."""

MOST_PARTS = 5
"""Largest number of parts of a bag with a clock each; stamps that jump more often are in disorder, and are sorted."""

_NANOSECONDS = 10**9


class BagMessage(NamedTuple):
    """Message of a bag, with its topic and type, and the time of its recording [ns], 0 if it is not known."""

    topic: str
    kind: str
    message: Any
    recorded: int = 0


Headers = Callable[[BagMessage], Sequence[tuple[str, Any]]]
"""Returns the frames and headers of a message that are of its time; none for transforms that hold at all times."""


def with_stamps(messages: Sequence[BagMessage], headers: Headers) -> list[str]:
    """Give messages of topics whose stamps are all the same the times of recording, and return notes.

    So robots without a clock stamp: by zero. The stamps are changed in place.
    """
    notes = []
    for topic, group in _by_topic(messages).items():
        stamps = {_stamp(header) for message in group for _, header in headers(message)}
        times = {message.recorded for message in group}
        if len(stamps) != 1 or 0 in times or (len(times) == 1 and stamps != {0}):
            continue
        for message in group:
            _stamp_as_recorded(message, headers)
        notes.append(f"all stamps on {topic} are {stamps.pop() / 1e9:g} s: the times of recording are used")
    return notes


def with_recorded_times(
    messages: Sequence[BagMessage], headers: Headers, is_scan: Callable[[BagMessage], bool]
) -> list[str]:
    """Give all messages the times of recording if scans and odometry are stamped by two clocks, and return notes.

    So does a simulator whose laser has simulated time, and whose odometry has the computer's. The stamps are changed
    in place, unless a time of recording is not known.
    """
    moving = [message for message in messages if headers(message)]
    scans, others = [each for each in moving if is_scan(each)], [each for each in moving if not is_scan(each)]
    if not scans or not others or not all(message.recorded for message in moving):
        return []
    (first, last), (begin, end) = _span(scans, headers), _span(others, headers)
    if last + APART * _NANOSECONDS >= begin and end + APART * _NANOSECONDS >= first:
        return []
    for message in moving:
        _stamp_as_recorded(message, headers)
    return [
        f"scans are stamped {first / 1e9:.1f} to {last / 1e9:.1f} s, and odometry and transforms {begin / 1e9:.1f} to "
        f"{end / 1e9:.1f} s, by another clock: the times of recording are used"
    ]


def of_one_clock(
    messages: Sequence[BagMessage], headers: Headers, is_scan: Callable[[BagMessage], bool]
) -> tuple[Sequence[BagMessage], list[str]]:
    """Return a bag without the parts whose times overlap since the robot's clock was set back, and notes.

    Of parts that overlap, the one with the most scans is kept. Transforms that hold at all times are of all parts.
    """
    parts: list[list[BagMessage]] = [[]]
    newest: dict[tuple[str, str], int] = {}
    for message in messages:
        stamps = {(message.topic, frame): _stamp(header) for frame, header in headers(message)}
        if any(stamp < newest.get(key, stamp) - SET_BACK * _NANOSECONDS for key, stamp in stamps.items()):
            parts.append([])
            newest.clear()
        parts[-1].append(message)
        newest |= {key: max(stamp, newest.get(key, stamp)) for key, stamp in stamps.items()}
    if not 1 < len(parts) <= MOST_PARTS:
        return messages, []
    counts = [sum(map(is_scan, part)) for part in parts]
    kept: list[int] = []
    spans = [_span(part, headers) for part in parts]
    for number in sorted(range(len(parts)), key=lambda number: -counts[number]):
        first, last = spans[number]
        if all(last < spans[other][0] or spans[other][1] < first for other in kept):
            kept.append(number)
    if len(kept) == len(parts):
        return messages, []
    note = (
        f"the robot's clock was set back in the bag: of {len(parts)} parts, {len(kept)} with most scans, whose times "
        f"do not overlap, are used: {sum(counts[number] for number in kept)} of {sum(counts)}"
    )
    always = (
        message for number, part in enumerate(parts) if number not in kept for message in part if not headers(message)
    )
    return [*always, *(message for number in sorted(kept) for message in parts[number])], [note]


def _span(part: Sequence[BagMessage], headers: Headers) -> tuple[int, int]:
    """Return the first and the last stamp in a part [ns]."""
    stamps = [_stamp(header) for message in part for _, header in headers(message)]
    return min(stamps), max(stamps)


def _by_topic(messages: Sequence[BagMessage]) -> dict[str, list[BagMessage]]:
    groups: defaultdict[str, list[BagMessage]] = defaultdict(list)
    for message in messages:
        groups[message.topic].append(message)
    return groups


def _stamp_as_recorded(message: BagMessage, headers: Headers) -> None:
    for _, header in headers(message):
        header.stamp.sec, header.stamp.nanosec = divmod(message.recorded, _NANOSECONDS)


def _stamp(header: Any) -> int:
    return int(header.stamp.sec) * _NANOSECONDS + int(header.stamp.nanosec)
