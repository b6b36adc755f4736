"""Joint maps: a robot that maps goes on with the map of several robots, which comes page by page by a service."""

import base64
import logging
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from ppaas.change_log import LogChange
from ppaas.errors import InvalidInput, PPaaSError, QuotaExceeded, Unavailable
from ppaas.geometry import Pose2D
from ppaas.mapping.live.joint_mapper import Adopted, Adoption, AdoptionWork, JointMapper
from ppaas.mapping.merging.united import frame_name
from ppaas.mapping.serialization.mapping_log import GrowingMapping, LogWriter
from ppaas.messages.geometry_msgs import Pose2D as Pose2DMessage
from ppaas.messages.slam_toolbox import UseJointMap, UseJointMapRequest, UseJointMapResponse
from ppaas.nodes.base import Context, Reply, Service, Timer
from ppaas.nodes.grid_slam.logbook import Logbook
from ppaas.nodes.jobs import LongWork

logger = logging.getLogger(__name__)

USE_JOINT_MAP = Service("grid_slam/use_joint_map", UseJointMap)

MOST_BYTES = 1 << 28
"""Largest joint map [bytes]."""

RETRY = 0.1
"""Time between attempts to take over a joint map that came while loops were closed [s]."""

RESERVED = 1 << 16
"""Numbers of log entries that are left for what is mapped while a joint map is made the robot's own."""

CHANGED = "the map of the robot was cleared or replaced meanwhile, or the robot was carried away: it is joined later"
"""Error for a joint map that its robot cannot go on with any more."""


class Current(NamedTuple):
    """Map that a robot makes.

    Parameters
    ----------
    mapper : JointMapper
    laser_frame : str
    most : int
        Largest number of key frames.
    """

    mapper: JointMapper
    laser_frame: str
    most: int


class PreparedJointMap(NamedTuple):
    """Joint map that a robot goes on with, and its log.

    Parameters
    ----------
    adopted : Adopted
    writer : LogWriter
        Of the log, which has all key frames of ``adopted``.
    change : LogChange
        The log so far.
    """

    adopted: Adopted
    writer: LogWriter
    change: LogChange


class _Waiting(NamedTuple):
    """Joint map that waits until other work on the map is done."""

    file: bytes
    current: Current
    reply: Reply
    robots: list[str]


class JointMaps:
    """Receives joint maps, and passes them to a mapper in jobs: no scan waits for it.

    Parameters
    ----------
    context : Context
        Of the node.
    current : callable
        Returns the map that grows; None if there is none.
    logbook : Logbook
        Log of the map.
    on_adopted : callable
        Called with what has changed, and a status text if other robots than before are in the joint map.
    on_ended : callable
        Called when other work on the map may begin, since one was taken over or refused.
    """

    def __init__(
        self,
        context: Context,
        current: Callable[[], Current | None],
        logbook: Logbook,
        on_adopted: Callable[[Adoption, str], None],
        on_ended: Callable[[], None],
    ) -> None:
        self._context, self._current, self._logbook = context, current, logbook
        self._on_adopted, self._on_ended = on_adopted, on_ended
        self._file, self._robots = bytearray(), list[str]()
        self._waiting: _Waiting | None = None
        self._timer: Timer | None = None

    def receive(self, request: UseJointMapRequest, reply: Reply) -> None:
        """Take a page; after the last one reply when the robot goes on with the map.

        Raises
        ------
        InvalidInput
            It is not the next page of a file.
        QuotaExceeded
            The file is too large.
        Unavailable
            The robot has no map that grows, or has another joint map in work.
        """
        if request.offset == 0:
            self._file.clear()
        _check_page(request, len(self._file))
        try:
            self._file += base64.b64decode(request.data, validate=True)
        except ValueError as error:  # of characters that are not ASCII, too
            raise InvalidInput(f"the page of the joint map is not base64: {error}") from error
        if len(self._file) < request.size:
            reply(UseJointMapResponse())
            return
        file, current = bytes(self._file), self._current()
        self._file.clear()
        if current is None:
            raise Unavailable("the robot has no map that grows yet: it cannot go on with a joint one")
        if self._timer is not None or self._waiting is not None:
            raise Unavailable("the robot is taking over a joint map just now: send this one later")
        self._waiting = _Waiting(file, current, reply, request.robots)
        self._begin()

    def _begin(self) -> None:
        """Start the job, or try again as soon as no other work on the map is running."""
        waiting = self._waiting
        assert waiting is not None
        file, current = waiting.file, waiting.current
        if not self._is_current(current.mapper):  # the result of its work may be dropped: it would never end
            self._stop_timer()
            self._finish(Unavailable(CHANGED))
            return
        work = current.mapper.adoption(file, current.laser_frame, current.most)
        if work is None:
            self._timer = self._timer or self._context.every(RETRY, self._begin)
            return
        self._stop_timer()
        number, solves = self._logbook.number + RESERVED, current.mapper.solves
        self._context.start(LongWork(partial(_prepared, work, number, solves)), self._finish)

    def _finish(self, prepared: PreparedJointMap | PPaaSError) -> None:
        self._use(prepared)
        self._on_ended()

    def _use(self, prepared: PreparedJointMap | PPaaSError) -> None:
        waiting, self._waiting = self._waiting, None
        assert waiting is not None
        mapper = waiting.current.mapper
        if not self._is_current(mapper):
            prepared = Unavailable(CHANGED)
        adoption, frame = None, frame_name(mapper.key_frames)
        try:
            adoption = mapper.adopt(None if isinstance(prepared, PPaaSError) else prepared.adopted)
        except PPaaSError as refused:
            prepared = refused
        if isinstance(prepared, PPaaSError) or adoption is None:
            error = prepared if isinstance(prepared, PPaaSError) else Unavailable(CHANGED)
            logger.warning("the robot keeps its own map: %s", error)
            waiting.reply(error)
            return
        self._logbook.replace(prepared.writer, prepared.change, len(prepared.adopted.mapping.frames))
        motion = adoption.motion
        self._on_adopted(adoption, self._news(waiting.robots, motion, frame_name(mapper.key_frames) != frame))
        waiting.reply(UseJointMapResponse(len(mapper.key_frames), Pose2DMessage(motion.x, motion.y, motion.theta)))

    def _news(self, robots: list[str], motion: Pose2D, is_other_frame: bool) -> str:
        """Return the status of a robot whose map was joined with others; empty if its robots and frame are the same."""
        before, self._robots = self._robots, robots
        joined = f"the map is joined with that of {' and '.join(robots)}; its frame"
        if is_other_frame:
            at = f"{motion.x:.2f} m, {motion.y:.2f} m, {motion.theta:.2f} rad"
            return f"{joined} is another one: the former origin is at ({at})"
        return f"{joined} stays" if robots != before else ""

    def _is_current(self, mapper: JointMapper) -> bool:
        current = self._current()
        return current is not None and current.mapper is mapper

    def _stop_timer(self) -> None:
        if self._timer is not None:
            self._timer.stop()
            self._timer = None


def _check_page(request: UseJointMapRequest, received: int) -> None:
    if not 0 < request.size <= MOST_BYTES:
        raise QuotaExceeded(f"a joint map may have up to {MOST_BYTES} bytes, not {request.size}")
    length = 3 * len(request.data) // 4
    if request.offset != received or received + length > request.size + 2:
        raise InvalidInput(
            f"{received} of {request.size} bytes of the joint map are here, and a page of about {length} bytes at "
            f"{request.offset} does not follow: begin at 0"
        )


def _prepared(work: AdoptionWork, number: int, solves: int, cancelled: Callable[[], bool]) -> PreparedJointMap:
    """Return the map that a robot goes on with, and its log from a number on; raises as the work does."""
    adopted = work(cancelled)
    mapping = adopted.mapping
    writer, change = LogWriter(mapping.laser_frame, number), LogChange([], [])
    growing = GrowingMapping(mapping.frames, mapping.graph, solves, [])
    while (more := writer.write(growing)) is not None:
        change = change.then(more)
    return PreparedJointMap(adopted, writer, change)
