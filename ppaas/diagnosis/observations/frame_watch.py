"""Frames of a robot as ``tf`` and ``tf_static`` give them: parents, age, and signs of two senders."""

import math
import statistics
from collections import deque
from dataclasses import dataclass, field

from ppaas.bounded_dict import BoundedDict
from ppaas.diagnosis.observations.facts import FrameFacts
from ppaas.messages.geometry_msgs import TransformStamped
from ppaas.messages.tf2_msgs import MAX_FRAMES
from ppaas.nodes.frames import PERSON
from ppaas.transforms.spatial import LatestFrames

MOST_POSITIONS = 40
"""Number of positions of a moving frame that are compared."""

FAR, NEAR = 0.05, 0.3
"""Two senders take turns if successive positions are farther apart than `FAR` [m] in the median, while every second one
is nearer than this part of that."""

MOST_PARENTS = 4
"""Largest number of parents of a frame that are kept."""

PARENT_AGE = 5.0
"""Time after which an earlier parent of a frame counts as given up [s]."""


@dataclass(slots=True)
class _Frame:
    parents: dict[str, float] = field(default_factory=dict)
    static: bool = False
    at: float = 0.0
    positions: deque[tuple[float, float]] = field(default_factory=lambda: deque(maxlen=MOST_POSITIONS))


class FrameWatch:
    """Frames that transforms name.

    Attributes
    ----------
    latest : LatestFrames
        Latest transform of each frame.
    """

    def __init__(self) -> None:
        self.latest = LatestFrames()
        self._frames: BoundedDict[str, _Frame] = BoundedDict(MAX_FRAMES)

    def hear(self, transforms: list[TransformStamped], now: float, *, static: bool) -> None:
        """Note the transforms of a message that arrived at monotonic time ``now`` [s]."""
        self.latest.hear(transforms)
        for transform in transforms:
            child, parent = transform.child_frame_id.lstrip("/"), transform.header.frame_id.lstrip("/")
            if "/" in child and PERSON.fullmatch(child):
                continue  # people come and go, and nothing of the robot is mounted on them
            frame = self._frames.get(child)
            if frame is None:
                frame = self._frames[child] = _Frame()
            frame.parents.pop(parent, None)
            frame.parents[parent] = now
            if len(frame.parents) > MOST_PARENTS:
                del frame.parents[next(iter(frame.parents))]
            frame.static, frame.at = static, now
            if not static:
                frame.positions.append((transform.transform.translation.x, transform.transform.translation.y))

    def facts(self, now: float) -> list[FrameFacts]:
        """Return the facts of all frames that have a parent, sorted by their names."""
        return [
            FrameFacts(
                name=name,
                parents=tuple(each for each, at in frame.parents.items() if at == frame.at or now - at < PARENT_AGE),
                static=frame.static,
                silence=now - frame.at,
                alternates=alternates([*frame.positions]),
            )
            for name, frame in sorted(self._frames.items())
        ]


def alternates(positions: list[tuple[float, float]]) -> bool:
    """Return whether positions jump to and fro, as with two senders that take turns."""
    if len(positions) < 8:
        return False
    steps, doubles = (
        statistics.median(math.dist(a, b) for a, b in zip(positions, positions[apart:], strict=False))
        for apart in (1, 2)
    )
    return steps > FAR and doubles < NEAR * steps
