"""Logged map: a node with the map that it makes, restored from a log or file, and continued by another node."""

import contextlib
import logging
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import ClassVar, NamedTuple, TypeVar

import msgspec

from ppaas.change_log import LogChange, LogEntry
from ppaas.decoding import from_json
from ppaas.errors import PPaaSError, QuotaExceeded, Unavailable
from ppaas.geometry import Pose2D
from ppaas.mapping.live.joint_mapper import JointMapper
from ppaas.mapping.live.live_mapper import LiveMapper
from ppaas.mapping.merging.united import frame_name
from ppaas.mapping.parameters import SlamParameters
from ppaas.mapping.parts.map_parts import check_is_main, current_part
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.mapping.serialization.mapping_log import LogWriter, read_log
from ppaas.messages.base.message import Message
from ppaas.messages.slam_toolbox import GetPoseGraphRequest
from ppaas.nodes.base import Context, Node
from ppaas.nodes.frames import MAP
from ppaas.nodes.grid_slam.joint_maps import Current
from ppaas.nodes.grid_slam.laser import MappingLaser
from ppaas.nodes.grid_slam.logbook import Head, Located, Logbook, resume
from ppaas.nodes.grid_slam.parameters import GridSlamParameters
from ppaas.nodes.jobs import LongWork, Work

T = TypeVar("T")


# -- jobs of ``grid_slam`` that make the map of a log or of a file; calls that depend on the map wait for them ---------


class MapJobs:
    """Runs one job at once, and calls that come meanwhile after it, in their order.

    Parameters
    ----------
    context : Context
        Of the node.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        self._running = False
        self._waiting: deque[Callable[[], None]] = deque()

    def start(self, work: Work[T], done: Callable[[T | PPaaSError], None]) -> None:
        """Start a job; ``done`` is called with its result in the node's thread. None may be running: see `run`."""
        self._running = True
        self._context.start(LongWork(work), partial(self._finish, done))

    def run(self, call: Callable[[], None]) -> None:
        """Call a function now, or as soon as no job is running. It raises nothing."""
        self._waiting.append(call)
        self._run_waiting()

    def _finish(self, done: Callable[[T | PPaaSError], None], result: T | PPaaSError) -> None:
        self._running = False
        done(result)
        self._run_waiting()

    def _run_waiting(self) -> None:
        while self._waiting and not self._running:
            self._waiting.popleft()()


# -- restoration of a map ----------------------------------------------------------------------------------------------


class RestoredMap(NamedTuple):
    """Map of a log.

    Parameters
    ----------
    laser : MappingLaser
    mapper : LiveMapper
    writer : LogWriter
        Of the same log, which it continues.
    """

    laser: MappingLaser
    mapper: LiveMapper
    writer: LogWriter


@dataclass(frozen=True, slots=True)
class Restoration:
    """Work that rebuilds the map of a log. It may be run again.

    Parameters
    ----------
    entries : sequence of LogEntry
        All entries, sorted by number.
    head : Head or None
        Where the robot is.
    parameters : SlamParameters
        Of the front end.
    new_mapper : callable
        Returns a mapper without a map for a laser.
    """

    entries: Sequence[LogEntry]
    head: Head | None
    parameters: SlamParameters
    new_mapper: Callable[[MappingLaser], LiveMapper]

    def __call__(self, _cancelled: Callable[[], bool]) -> RestoredMap:
        """Return the map.

        Raises
        ------
        InvalidGraph
            The log is damaged.
        QuotaExceeded
            The map has more key frames than allowed.
        """
        mapping = read_log(self.entries)
        writer = LogWriter.resumed(self.entries, mapping)
        laser = MappingLaser(mapping.laser_frame, mapping.frames.geometry, self.parameters)
        mapper = self.new_mapper(laser)
        resume(mapper, mapping, self.head)
        draw(mapper)
        return RestoredMap(laser, mapper, writer)


def draw(mapper: LiveMapper) -> None:
    """Draw the key frames of a mapper that was just made, while no scan waits for it.

    A map that is too large to be drawn is reported when the next key frame is.
    """
    with contextlib.suppress(QuotaExceeded):
        mapper.draw()


logger = logging.getLogger(__name__)


# -- logged map --------------------------------------------------------------------------------------------------------


class LoggedMapNode(Node):
    """Node with a map that grows: the log has the map, and the checkpoint only where the robot is in it.

    Parameters
    ----------
    context : Context
        The node's context.
    parameters : GridSlamParameters
    """

    keeps_log: ClassVar[bool] = True

    def __init__(self, context: Context, parameters: GridSlamParameters) -> None:
        super().__init__(context)
        self._parameters, self._front_end = parameters, parameters.front_end()
        self._paused, self._map_error = parameters.paused_new_measurements, ""
        self._laser: MappingLaser | None = None
        self._mapper: LiveMapper | None = None
        self._map_to_odom = Pose2D(0.0, 0.0, 0.0)
        self._logbook = Logbook()
        self._head: Head | Located | None = None
        self._jobs = MapJobs(context)
        self._restoration: Restoration | None = None

    def _new_mapper(self, laser: MappingLaser) -> LiveMapper:
        parameters = self._parameters
        return JointMapper(
            laser.geometry, self._front_end, parameters.closures(), parameters.drawing(), parameters.lifelong()
        )

    def _mapping(self) -> Mapping:
        """Return the mapping as it is now; raises ``Unavailable`` if there is none yet."""
        if self._mapper is None or self._laser is None or not len(self._mapper.key_frames):
            raise Unavailable("the robot has no map yet: drive it, with scans and odometry")
        return self._mapper.mapping(self._laser.frame)

    def _current_part(self, request: Message) -> Mapping:
        """Return the mapping that the map shows, for a call of ``serialize_map`` or ``pose_graph``.

        Raises
        ------
        Unavailable
            There is none yet, or its file would lack the larger part of what the robot has seen.
        """
        mapping = self._mapping()
        assert self._mapper is not None
        if not isinstance(request, GetPoseGraphRequest) or request.offset == 0:
            check_is_main(self._mapper.parts, len(mapping.frames))
        return current_part(mapping, self._mapper.parts)

    @property
    def _growing(self) -> LiveMapper | None:
        """The mapper, if it has a map that grows."""
        mapper = self._mapper
        return mapper if mapper is not None and mapper.keeps and len(mapper.key_frames) else None

    @property
    def has_log_change(self) -> bool:
        """Whether there is a key frame that is not in the log, or the log is of a map that no longer grows."""
        growing = self._growing
        return self._logbook.has_rest if growing is None else self._logbook.has_change(growing)

    def log_change(self) -> LogChange | None:
        """Return the key frames and closures since the last call; without a map that grows, the log is emptied."""
        return self._logbook.rest() if self._growing is None else self._logbook.change(self._growing)

    def whole_log(self) -> LogChange | None:
        """Return a change that replaces the log by one of the map as it is now; without one, as `log_change`."""
        if self._restoration is not None:
            return LogChange(list(self._restoration.entries), [])
        if self._growing is None or self._laser is None:
            return self._logbook.rest()
        return self._logbook.rewrite(self._growing, self._laser.frame)

    def checkpoint(self) -> bytes | None:
        """Return where the robot is in its map as JSON; a map that grows is in the log."""
        if self._restoration is not None and self._restoration.head is not None:
            return msgspec.json.encode(msgspec.structs.replace(self._restoration.head, paused=self._paused))
        if self._growing is not None:
            shared = self._is_shared(self._growing)
            head = self._logbook.head(self._growing, self._map_to_odom, paused=self._paused, shared=shared)
            return msgspec.json.encode(msgspec.structs.replace(head, without_odometry=self._is_without_odometry))
        if self._mapper is None or self._laser is None or self._mapper.keeps:
            return None
        robot = self._mapper.pose @ self._laser.geometry.mount.inverse()
        return msgspec.json.encode(Located((robot.x, robot.y, robot.theta), self._paused))

    def restore(self, state: bytes) -> None:
        """Keep the head until the log is there; in localization search the next scan around the pose."""
        restored = from_json(state, Head | Located)
        self._paused, self._head = restored.paused, restored
        if isinstance(restored, Located) and self._mapper is not None and self._laser is not None:
            if self._mapper.keeps:  # the map was continued, and then no longer changed
                mapping, self._mapper = self._mapping(), self._new_mapper(self._laser)
                self._mapper.load(mapping, Pose2D(*restored.robot), keeps=False)
                self._logbook.end()
            self._mapper.place(Pose2D(*restored.robot))

    def restore_log(self, entries: Sequence[LogEntry]) -> None:
        """Continue the map of a log, which is rebuilt in a job. Until then the robot is where its odometry says.

        If it cannot be read, ``grid_slam/status`` reports that, and the map is lost.
        """
        self._logbook.take_over(entries)
        if isinstance(self._head, Located):  # the log ended, but its removal was not stored
            self._logbook.end()
            return
        before, (self._laser, self._mapper) = (self._laser, self._mapper), (None, None)
        if self._head is not None and self._head.correction is not None:
            self._map_to_odom = Pose2D(*self._head.correction)
        self._restoration = Restoration(entries, self._head, self._front_end, self._new_mapper)
        self._jobs.start(self._restoration, partial(self._on_restored, before))

    def _on_restored(
        self, before: tuple[MappingLaser | None, LiveMapper | None], restored: RestoredMap | PPaaSError
    ) -> None:
        """Use the map of the log. If it is lost, go on with the one that was loaded before, or begin another."""
        self._restoration = None
        if isinstance(restored, PPaaSError):
            logger.warning("the map that the robot was making is lost: %s", restored)
            self._map_error = f"the map so far is lost: {restored}"
            self._map_to_odom, (self._laser, self._mapper) = Pose2D(0.0, 0.0, 0.0), before
            if self._laser is not None:
                self._logbook.begin(self._laser.frame)
        else:
            laser, mapper, writer = restored
            self._laser, self._mapper = laser, mapper
            self._logbook.resume(writer, len(mapper.key_frames))
            self._map_to_odom = mapper.pose @ laser.geometry.mount.inverse() @ mapper.odometry.inverse()
            self._restored(mapper, shared=isinstance(self._head, Head) and self._head.shared)
        self._ready()

    def _frame_name(self, mapper: LiveMapper) -> str:
        """Return the name of the map frame for other robots that know it."""
        return MAP if self._parameters.map_file_name else frame_name(mapper.key_frames)

    def _joinable(self) -> Current | None:
        """Return the map if it may become a part of a joint one."""
        mapper, laser = self._growing, self._laser
        if self._parameters.mode != "mapping" or laser is None or not isinstance(mapper, JointMapper):
            return None
        if not mapper.parts.is_whole:
            return None
        return Current(mapper, laser.frame, self._front_end.max_key_frames)

    @property
    def _is_without_odometry(self) -> bool:
        """Whether the map is made of scans alone."""
        return False

    def _is_shared(self, _mapper: LiveMapper) -> bool:
        """Return whether a map is in a frame that other robots know."""
        return False

    def _restored(self, mapper: LiveMapper, *, shared: bool) -> None:
        """Called with a mapper whose map was restored, and whether its frame is one that other robots know."""

    def _ready(self) -> None:
        """Called when scans may be used, because a log was read or could not be."""
