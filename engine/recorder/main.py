"""Process of the recorder of a machine: writes the batches that its agent sends, until the agent closes the connection.

Its standard input is that connection, a Unix socket with frames in both directions.
"""

import asyncio
import json
import logging
import os
import signal
import socket
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from engine.protocols.framing import FrameStream
from engine.recorder.frames import Left, Told, ToRecorder
from engine.recorder.robot_recorder import RobotRecorder
from ppaas.clock import monotonic
from ppaas.errors import PPaaSError
from ppaas.log_lines import log_lines
from ppaas.recording.batches import batch_of
from ppaas.recording.mcap_library import mcap_modules
from ppaas.wire.ros.own_types import types_with
from storage.disk_space import FULL, DiskReserve
from storage.recordings import RecordingsFolder

logger = logging.getLogger(__name__)

LOOK = 1.0
"""Period at which files are flushed and the disk is checked while nothing arrives [s]."""

PAUSE = 5.0
"""Time after a problem for which nothing is written for a robot [s]."""

NICE = 5
"""Addition to the nice value: robots' containers come first."""

MISSING = 3
"""Exit status if a library is not installed."""

Tell = Callable[[Told], None]
Work = Callable[[RobotRecorder], None]


class MachineRecorder:
    """Recorders of all robots of a machine.

    Parameters
    ----------
    folder : RecordingsFolder
    reserve : DiskReserve, optional
        Reserve of disk space of the cloud; nothing is written while it is used up.
    tell : callable
        Called with the report for the clone of a robot.
    """

    def __init__(self, folder: RecordingsFolder, reserve: DiskReserve | None, tell: Tell) -> None:
        self._folder, self._reserve, self._tell = folder, reserve, tell
        self._robots: dict[tuple[str, str], RobotRecorder] = {}
        self._paused: dict[tuple[str, str], float] = {}
        self._looked = float("-inf")

    def take(self, frame: ToRecorder, now: float) -> None:
        """Execute a frame [s, monotonic]; a failure is reported to the clone, and ends the files of its robot."""
        key = frame.user, frame.robot
        if isinstance(frame, Left):
            self._guard(key, lambda robot: robot.finish(), now)
            self._robots.pop(key, None)
            self._paused.pop(key, None)
        elif self._may_write(key, now):
            if key not in self._robots:
                self._robots[key] = RobotRecorder(self._folder, *key)
                self._tell(Told(*key, forgotten=True))
            self._guard(key, lambda robot: robot.take(batch_of(frame.batch), now), now)

    def look(self, now: float) -> None:
        """Flush the files that are due; end them all if the disk is full."""
        if now - self._looked < LOOK:
            return
        self._looked = now
        full = self._reserve is not None and self._reserve.is_full()
        for key in list(self._robots):
            if full:
                self._fail(key, FULL, now)
            else:
                self._guard(key, lambda robot: robot.flush(now), now)

    def close(self) -> None:
        """Finish all files."""
        for key in list(self._robots):
            self._guard(key, lambda robot: robot.finish(), 0.0)

    def _may_write(self, key: tuple[str, str], now: float) -> bool:
        if now < self._paused.get(key, float("-inf")):
            return False
        if self._paused.pop(key, None) is not None:
            if self._reserve is not None and self._reserve.is_full():
                self._paused[key] = now + PAUSE
                return False
            self._tell(Told(*key))
        return True

    def _guard(self, key: tuple[str, str], work: Work, now: float) -> None:
        robot = self._robots.get(key)
        if robot is None:
            return
        try:
            work(robot)
        except OSError as error:
            self._fail(key, f"the disk does not take the recording: {error.strerror or error}", now)
        except PPaaSError as error:
            self._fail(key, str(error), now, complete=True)
        except Exception as error:
            # A fault that the messages of one robot cause must not end the recordings of all others.
            logger.exception("the recorder of robot %s of user %s failed", key[1], key[0])
            self._fail(key, f"internal error of the recorder: {type(error).__name__}", now, complete=True)

    def _fail(self, key: tuple[str, str], problem: str, now: float, *, complete: bool = False) -> None:
        logger.warning("robot %s of user %s is not recorded: %s", key[1], key[0], problem)
        robot = self._robots.pop(key)
        if complete:
            with suppress(OSError):
                robot.finish()
        robot.abandon()
        self._paused[key] = now + PAUSE
        self._tell(Told(*key, problem=problem))


async def run(folder: Path, reserve: Path | None, connection: socket.socket) -> None:
    """Execute frames of the agent until it closes the connection, then finish all files."""
    stream = FrameStream[ToRecorder](*await asyncio.open_connection(sock=connection), ToRecorder)
    recorder = MachineRecorder(
        RecordingsFolder(folder), None if reserve is None else DiskReserve(reserve), stream.write
    )
    while True:
        with suppress(TimeoutError):
            async with asyncio.timeout(LOOK):
                if (frame := await stream.receive()) is None:
                    break
                recorder.take(frame, monotonic())
        recorder.look(monotonic())
    recorder.close()
    await stream.close()


def main() -> None:
    """Run the recorder with the settings in the first argument, JSON with ``folder`` and ``reserve``."""
    log_lines("%(levelname)s recorder %(name)s: %(message)s", process="recorder", level=logging.INFO)
    for number in (signal.SIGINT, signal.SIGTERM):  # the agent ends it by closing its connection, after the containers
        signal.signal(number, signal.SIG_IGN)
    os.nice(NICE)
    settings = json.loads(sys.argv[1])
    try:
        mcap_modules()
        types_with("std_msgs/Header")
    except PPaaSError as error:
        logger.warning("nothing is recorded: %s", error)
        sys.exit(MISSING)
    reserve = Path(settings["reserve"]) if settings["reserve"] else None
    asyncio.run(run(Path(settings["folder"]), reserve, socket.socket(fileno=sys.stdin.fileno())))


if __name__ == "__main__":
    main()
