"""Transforms that a robot sends itself: its static ones, and the frames that its ``tf`` moves."""

from collections.abc import Iterable, Iterator
from contextlib import suppress

import msgspec

from ppaas.decoding import from_json
from ppaas.errors import TransformError
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import TransformStamped
from ppaas.messages.tf2_msgs import MAX_FRAMES
from ppaas.transforms.spatial import Rigid

KEPT = 200
"""Largest number of static frames in a checkpoint."""

FRESH = 1.0
"""Time after a transform for which the robot's ``tf`` counts as the source of its frame [s]."""


class RobotTransforms:
    """Transforms that a robot sends itself."""

    def __init__(self) -> None:
        self._static: dict[str, tuple[str, Rigid]] = {}
        self._moved: dict[str, float] = {}
        self._state: bytes | None = None

    def note_static(self, transforms: Iterable[TransformStamped]) -> None:
        """Note static transforms; those that are not rigid are ignored."""
        for child, each, pose in _rigid(transforms):
            if child in self._static or len(self._static) < KEPT:
                self._static[child] = each.header.frame_id.lstrip("/"), pose
        self._state = msgspec.json.encode([(child, *known) for child, known in self._static.items()])

    def note_moving(self, transforms: Iterable[TransformStamped], now: float) -> None:
        """Note transforms that arrived at a time [s]; those that are not rigid move nothing."""
        for child, _, _ in _rigid(transforms):
            if child in self._moved or len(self._moved) < MAX_FRAMES:
                self._moved[child] = now

    def moves(self, child: str, now: float) -> bool:
        """Return whether the robot's ``tf`` moves a frame now [s]."""
        return now - self._moved.get(child, float("-inf")) <= FRESH

    def state(self) -> bytes | None:
        """Return the static transforms as JSON, None without any."""
        return self._state

    def restore(self, state: bytes) -> list[TransformStamped]:
        """Note the static transforms of a `state`, and return them."""
        for child, parent, pose in from_json(state, list[tuple[str, str, Rigid]]):
            self._static[child] = parent, pose
        self._state = state
        return [
            TransformStamped(Header(frame_id=parent), child, pose.to_message())
            for child, (parent, pose) in self._static.items()
        ]


def _rigid(transforms: Iterable[TransformStamped]) -> Iterator[tuple[str, TransformStamped, Rigid]]:
    """Yield the transforms that are rigid, with the name of the child."""
    for each in transforms:
        with suppress(TransformError):
            yield each.child_frame_id.lstrip("/"), each, Rigid.of(each.transform)
