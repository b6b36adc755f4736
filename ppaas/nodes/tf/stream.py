"""Stream of transforms of some frames in another, which are published when they change.

The rules are the same as in ``tf2_web_republisher`` (``tf_pair.h``): a frame is published at first, and then whenever
it has moved or turned by more than the threshold since it was last published; with a threshold of zero, every time.
"""

import math
from collections.abc import Callable

from ppaas.errors import InvalidInput, TransformError
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import TransformStamped
from ppaas.messages.tf2_web_republisher import TFSubscriptionGoal
from ppaas.nodes.base import Context
from ppaas.transforms.spatial import LatestFrames, Rigid

MAX_SOURCES = 100
"""Largest number of frames in a stream."""

MAX_FRAME_NAME = 255
"""Longest name of a frame [characters]."""

MIN_RATE, MAX_RATE = 0.1, 50.0
"""Limits of the rate of a stream [Hz]; higher rates are reduced to the highest."""


def check_wanted(goal: TFSubscriptionGoal) -> None:
    """Check that a request is valid.

    Raises
    ------
    InvalidInput
        There are too many frames, the name of one is empty or too long, or a threshold or rate is out of range.
    """
    if len(goal.source_frames) > MAX_SOURCES:
        raise InvalidInput(f"source_frames may have at most {MAX_SOURCES} frames, not {len(goal.source_frames)}")
    for frame in (*goal.source_frames, goal.target_frame):
        if not 0 < len(frame.lstrip("/")) <= MAX_FRAME_NAME:
            raise InvalidInput(f"the name of a frame must have 1 to {MAX_FRAME_NAME} characters, not {frame[:32]!r}")
    for name, value in (("angular_thres", goal.angular_thres), ("trans_thres", goal.trans_thres)):
        if not (math.isfinite(value) and value >= 0.0):
            raise InvalidInput(f"{name} must be finite and at least 0, not {value}")
    if not (math.isfinite(goal.rate) and goal.rate >= MIN_RATE):
        raise InvalidInput(f"rate must be at least {MIN_RATE:g} Hz, not {goal.rate}")


class TfStream:
    """Publishes transforms while its topic has subscribers.

    Parameters
    ----------
    context : Context
        The node's context.
    frames : LatestFrames
        Latest transforms of all frames.
    wanted : TFSubscriptionGoal
        Frames, thresholds and rate.
    topic : str
        Topic of the stream.
    patience : float
        Time for which the topic may have no subscribers [s].
    publish : callable
        Publishes transforms.
    abandoned : callable
        Called when that time has passed.

    Raises
    ------
    InvalidInput
        See ``check_wanted``.
    """

    def __init__(
        self, context: Context, frames: LatestFrames, wanted: TFSubscriptionGoal,
        *, topic: str, patience: float,
        publish: Callable[[list[TransformStamped]], None], abandoned: Callable[[], None],
    ) -> None:  # fmt: skip
        check_wanted(wanted)
        self._context = context
        self._frames = frames
        self._sources = [frame.lstrip("/") for frame in wanted.source_frames]
        self._target = wanted.target_frame.lstrip("/")
        self._turn, self._move = wanted.angular_thres, wanted.trans_thres
        self._topic = topic
        self._patience = patience
        self._publish = publish
        self._abandoned = abandoned
        self._last: dict[str, Rigid] = {}
        self._silence = 0.0
        self._period = 1.0 / min(wanted.rate, MAX_RATE)
        self._timer = context.every(self._period, self._look)

    def stop(self) -> None:
        """Stop the stream."""
        self._timer.stop()

    def _look(self) -> None:
        if not self._context.has_subscribers(self._topic):
            self._last.clear()  # the next subscriber receives all frames
            self._silence += self._period
            if self._silence >= self._patience:
                self._abandoned()
            return
        self._silence = 0.0
        moved = [transform for source in self._sources if (transform := self._moved(source)) is not None]
        if moved:
            self._publish(moved)

    def _moved(self, source: str) -> TransformStamped | None:
        try:
            pose = self._frames.lookup(self._target, source)
        except TransformError:
            return None  # it may appear later
        last = self._last.get(source)
        always = self._turn == 0.0 or self._move == 0.0
        if last is not None and not always and self._near(last, pose):
            return None
        self._last[source] = pose
        header = Header(stamp=Time.of(self._context.now()), frame_id=self._target)
        return TransformStamped(header, source, pose.to_message())

    def _near(self, last: Rigid, pose: Rigid) -> bool:
        return last.distance_to(pose) <= self._move and last.angle_to(pose) <= self._turn
