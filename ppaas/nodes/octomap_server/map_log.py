"""Log of the 3D map of ``octomap_server``: changes are collected in jobs, and stored with checkpoints."""

import logging
from collections.abc import Callable, Sequence
from functools import partial

from ppaas.change_log import LogChange, LogEntry
from ppaas.errors import PPaaSError
from ppaas.mapping.volume.key_frame_poses import KeyFramePoses
from ppaas.nodes.octomap_server.job_queue import JobQueue
from ppaas.nodes.octomap_server.map_work import MapWork

logger = logging.getLogger(__name__)


class MapLog:
    """Log of a map.

    Parameters
    ----------
    jobs : JobQueue
        Jobs of the node.
    work : MapWork
        The map.

    Attributes
    ----------
    loss : str
        Reason for which the map of the log is lost; empty if it is not.
    """

    def __init__(self, jobs: JobQueue, work: MapWork) -> None:
        self.loss = ""
        self._jobs, self._work = jobs, work
        self._change: LogChange | None = None
        self._logged, self._running = 0, False

    def write(self, revision: int, key_frames: KeyFramePoses) -> None:
        """Collect what has changed in a job, if the map has another revision than at the last call.

        Parameters
        ----------
        revision : int
            Of the map.
        key_frames : KeyFramePoses
            Key frames at whose poses it is.
        """
        if revision != self._logged and not self._running:
            self._running = True
            self._jobs.add(partial(self._work.log_change, key_frames), partial(self._on_written, revision))

    def take(self) -> LogChange | None:
        """Return what was collected since the last call; None if nothing was."""
        change, self._change = self._change, None
        return change

    def restore(self, entries: Sequence[LogEntry], done: Callable[[KeyFramePoses | None], None]) -> None:
        """Read the map of a log in a job.

        Parameters
        ----------
        entries : sequence of LogEntry
            All entries, sorted by number.
        done : callable
            Called with the key frames of the map, at whose poses it is; None if it is lost.
        """
        self._jobs.add(partial(self._work.restore, entries), partial(self._on_restored, done))

    def _on_written(self, revision: int, change: LogChange | PPaaSError | None) -> None:
        self._running = False
        if isinstance(change, PPaaSError):
            logger.warning("the log of the 3D map was not written: %s", change)
            return
        self._logged = revision
        if change is not None:
            self._change = change if self._change is None else self._change.then(change)

    def _on_restored(self, done: Callable[[KeyFramePoses | None], None], result: KeyFramePoses | PPaaSError) -> None:
        if isinstance(result, PPaaSError):
            logger.warning("the 3D map that the robot was making is lost: %s", result)
            self.loss = f"the 3D map so far is lost: {result}"
        done(None if isinstance(result, PPaaSError) else result)
