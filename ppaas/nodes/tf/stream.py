"""One stream of transforms: where some frames lie in another, told when they have moved.

The rules are those of ``tf2_web_republisher`` (``tf_pair.h``): a frame is told of at first, and from then on when it
has moved or turned by more than its threshold since it was last told of; with a threshold of zero, each time.
"""

import math
from collections.abc import Callable

from ppaas.errors import InvalidInput, TransformError
from ppaas.messages.geometry_msgs import TransformStamped
from ppaas.messages.std_msgs import Header, Time
from ppaas.messages.tf2_web_republisher import TFSubscriptionGoal
from ppaas.nodes.base import Context
from ppaas.transforms.spatial import LatestFrames, Rigid

MAX_SOURCES = 100
MAX_FRAME_NAME = 255
MIN_RATE, MAX_RATE = 0.1, 50.0
"""How often a stream may be looked at [Hz]; who asks for more gets the most."""


def check_wanted(goal: TFSubscriptionGoal) -> None:
    """Refuse what no stream can be made of.

    Raises
    ------
    InvalidInput
        Too many frames, one without a name or with a long one, a threshold or rate out of range.
    """
    if len(goal.source_frames) > MAX_SOURCES:
        raise InvalidInput(f"at most {MAX_SOURCES} source_frames, not {len(goal.source_frames)}")
    for frame in (*goal.source_frames, goal.target_frame):
        if not 0 < len(frame.lstrip("/")) <= MAX_FRAME_NAME:
            raise InvalidInput(f"a frame has a name of up to {MAX_FRAME_NAME} characters, not {frame[:32]!r}")
    for name, value in (("angular_thres", goal.angular_thres), ("trans_thres", goal.trans_thres)):
        if not (math.isfinite(value) and value >= 0.0):
            raise InvalidInput(f"{name} must be a finite number from 0 up, not {value}")
    if not (math.isfinite(goal.rate) and goal.rate >= MIN_RATE):
        raise InvalidInput(f"rate must be at least {MIN_RATE:g} Hz, not {goal.rate}")


class TfStream:
    """Tells of frames while somebody hears it, and does nothing but wait while nobody does.

    Parameters
    ----------
    context : Context
        Of the node.
    frames : LatestFrames
        Where all frames lie.
    wanted : TFSubscriptionGoal
        Which of them, and when.
    topic : str
        On which it is told.
    patience : float
        How long nobody may hear the topic [s].
    tell : callable
        Publishes transforms.
    unheard : callable
        Called when patience has run out.

    Raises
    ------
    InvalidInput
        As ``check_wanted``.
    """

    def __init__(
        self, context: Context, frames: LatestFrames, wanted: TFSubscriptionGoal,
        *, topic: str, patience: float, tell: Callable[[list[TransformStamped]], None], unheard: Callable[[], None],
    ) -> None:  # fmt: skip
        check_wanted(wanted)
        self._context = context
        self._frames = frames
        self._sources = [frame.lstrip("/") for frame in wanted.source_frames]
        self._target = wanted.target_frame.lstrip("/")
        self._turn, self._move = wanted.angular_thres, wanted.trans_thres
        self._topic = topic
        self._patience = patience
        self._tell = tell
        self._unheard = unheard
        self._told: dict[str, Rigid] = {}
        self._silence = 0.0
        self._period = 1.0 / min(wanted.rate, MAX_RATE)
        self._timer = context.every(self._period, self._look)

    def stop(self) -> None:
        """Tell no more."""
        self._timer.stop()

    def _look(self) -> None:
        if not self._context.is_heard(self._topic):
            self._told.clear()  # who hears it next is told of all
            self._silence += self._period
            if self._silence >= self._patience:
                self._unheard()
            return
        self._silence = 0.0
        moved = [transform for source in self._sources if (transform := self._moved(source)) is not None]
        if moved:
            self._tell(moved)

    def _moved(self, source: str) -> TransformStamped | None:
        try:
            pose = self._frames.lookup(self._target, source)
        except TransformError:
            return None  # it may come yet
        told = self._told.get(source)
        always = self._turn == 0.0 or self._move == 0.0
        if told is not None and not always and self._near(told, pose):
            return None
        self._told[source] = pose
        header = Header(stamp=Time.of(self._context.now()), frame_id=self._target)
        return TransformStamped(header, source, pose.to_message())

    def _near(self, told: Rigid, pose: Rigid) -> bool:
        return told.distance_to(pose) <= self._move and told.angle_to(pose) <= self._turn
