"""Check of clones in a process beside the endpoint, which need not load their kernels and plug-ins.

The process is started for the first file and kept for the next ones. It compiles no kernels: building a clone computes
next to nothing, so plain Python does.
"""

import asyncio
import contextlib
import hashlib
import logging
import os
import sys
from asyncio.subprocess import PIPE, Process
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
from msgspec.structs import replace

from engine.specs.clone_to_check import CloneToCheck
from ppaas.bounded import BoundedDict
from ppaas.errors import RobotFault, Unavailable
from ppaas.plugins import permitted

if TYPE_CHECKING:
    from endpoints.robot_checks import check_program  # noqa: F401 - the program named below

logger = logging.getLogger(__name__)

PROGRAM = ("-m", "endpoints.robot_checks.check_program")
"""Arguments of Python that run the program; the permitted plug-ins, the parent process and the folder follow."""

TIME_LIMIT = 25.0
"""Time limit of one check, the start of the process included [s]. Clients wait for 30 s."""

IDLE = 120.0
"""Time without checks after which the process is ended [s]; it takes 120 MB."""

MOST_ACCEPTED = 1000
"""Number of accepted files that are not checked again: robots of a fleet differ in little but their names."""

_MOST_BYTES = 1 << 24

_answers = msgspec.json.Decoder(list[RobotFault])


class CloneChecker:
    """Checks one clone after the other; for use on one event loop.

    Parameters
    ----------
    folder : Path
        Folder for temporary files; a process that is killed may leave some.
    seconds : float
        Time limit of one check [s].
    idle : float
        Time without checks after which the process is ended [s].
    """

    def __init__(self, folder: Path, seconds: float = TIME_LIMIT, idle: float = IDLE) -> None:
        self._folder = folder
        self._seconds = seconds
        self._idle = idle
        self._process: asyncio.Task[Process] | None = None
        self._dismissal: asyncio.TimerHandle | None = None
        self._turn = asyncio.Lock()
        self._accepted: BoundedDict[bytes, None] = BoundedDict(MOST_ACCEPTED)

    async def faults(self, clone: CloneToCheck) -> list[RobotFault]:
        """Return what the clone of a robot would refuse; nothing if it would be built.

        Raises
        ------
        Unavailable
            The check took too long, or its process exited.
        """
        if clone.is_usual:
            return []
        common = replace(clone, robot=replace(clone.robot, id="robot", initial_pose=(0.0, 0.0, 0.0)))
        request = msgspec.json.encode(common) + b"\n"
        key = hashlib.sha256(request).digest()
        if key in self._accepted:
            return []
        async with self._turn:
            found = await self._checked(request)
        if not found:
            self._accepted[key] = None
        return found

    async def close(self) -> None:
        """End the process."""
        async with self._turn:
            self._stay()
            await self._end()

    async def _checked(self, request: bytes) -> list[RobotFault]:
        self._stay()
        try:
            async with asyncio.timeout(self._seconds):
                known = self._process is not None
                answer = await self._answer(request)
                if answer is None and known:  # it was killed since the file before
                    answer = await self._answer(request)
        except TimeoutError as error:
            raise Unavailable(
                f"the robot file was not checked within {self._seconds:g} s: the computer is busy, or a plug-in of the "
                "robot hangs; try again"
            ) from error
        finally:
            self._dismissal = asyncio.get_running_loop().call_later(self._idle, self._dismiss)
        if answer is None:
            raise Unavailable("the process that checks robot files exited: try again, or see the log of the cloud")
        return answer

    async def _answer(self, request: bytes) -> list[RobotFault] | None:
        if self._process is None:
            self._process = asyncio.create_task(_started(self._folder))
        try:
            process = await asyncio.shield(self._process)  # a start that takes long goes on for the next request
        except OSError as error:
            self._process = None
            raise Unavailable(f"the process that checks robot files cannot be started: {error.strerror}") from error
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            with contextlib.suppress(ConnectionError):
                process.stdin.write(request)
                await process.stdin.drain()
            line = await process.stdout.readline()
        except BaseException:
            await self._end()  # the next request must not get the answer to this one
            raise
        if not line.endswith(b"\n"):
            logger.error("the process that checks robot files exited with status %s", await self._end())
            return None
        return _answers.decode(line)

    def _stay(self) -> None:
        if self._dismissal is not None:
            self._dismissal.cancel()
            self._dismissal = None

    def _dismiss(self) -> None:
        if not self._turn.locked():
            self._ending = asyncio.create_task(self.close())

    async def _end(self) -> int | None:
        """Kill the process, and return its exit status; None if there is none."""
        started, self._process = self._process, None
        if started is None:
            return None
        if not started.done():
            started.cancel()
        await asyncio.wait((started,))
        if started.cancelled() or started.exception() is not None:
            return None
        process = started.result()
        with contextlib.suppress(ProcessLookupError):
            process.kill()
        return await process.wait()


async def _started(folder: Path) -> Process:
    """Return a new process, once it has written that it is ready, or has exited."""
    arguments = (*PROGRAM, msgspec.json.encode(permitted()).decode(), str(os.getpid()), str(folder))
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    process = await asyncio.create_subprocess_exec(
        sys.executable, *arguments, stdin=PIPE, stdout=PIPE, limit=_MOST_BYTES, env=environment
    )
    assert process.stdout is not None
    try:
        await process.stdout.readline()
    except BaseException:
        process.kill()
        raise
    return process
