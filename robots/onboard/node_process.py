"""The process that local nodes run in, as the local node manager holds it."""

import asyncio
import contextlib
import itertools
import logging
import sys
from asyncio.subprocess import PIPE, Process
from collections.abc import Callable
from typing import TypeVar

import msgspec

from ppaas.errors import Unavailable, rebuild
from robots.onboard import executor
from robots.onboard.executor import protocol

logger = logging.getLogger(__name__)

A = TypeVar("A", bound=protocol.Answer)

START_TIMEOUT = 90.0
"""Seconds to get ready; the first start on a computer compiles the kernels."""
ANSWER_TIMEOUT = 5.0
"""Seconds; who takes longer is frozen."""
CALL_TIMEOUT = 60.0
"""Seconds that a call of a service may take, as in the cloud."""


class NodeProcess:
    """Starts the process, tells it things, and is told what its nodes say.

    Parameters
    ----------
    said : callable
        Takes what a node says.
    ended : callable
        Called once the process is gone.
    """

    def __init__(self, said: Callable[[protocol.Said], None], ended: Callable[[], None]) -> None:
        self._said = said
        self._ended = ended
        self._process: Process | None = None
        self._reading: asyncio.Task[None] | None = None
        self._answer: asyncio.Future[protocol.Answer] | None = None
        self._given_up = 0
        self._one_at_a_time = asyncio.Lock()
        self._numbers = itertools.count(1)
        self._calls: dict[int, asyncio.Future[protocol.Replied]] = {}

    @property
    def alive(self) -> bool:
        """Tell whether it runs."""
        return self._process is not None and self._process.returncode is None and not self._is_read_out

    @property
    def pid(self) -> int | None:
        """Of the process; None where there is none."""
        return self._process.pid if self._process is not None else None

    @property
    def _is_read_out(self) -> bool:
        return self._reading is None or self._reading.done()

    async def start(self, begin: protocol.Begin) -> None:
        """Start it, and wait until nodes may come.

        Raises
        ------
        Unavailable
            It ended, or is not ready in time.
        PPaaSError
            What it was told cannot be.
        """
        command = (sys.executable, "-m", executor.__name__)
        # A Ctrl-C is for the robot's program, which has nodes to give back before this may end.
        self._process = await asyncio.create_subprocess_exec(
            *command, stdin=PIPE, stdout=PIPE, limit=protocol.MAX_LINE, start_new_session=True
        )
        self._reading = asyncio.create_task(self._read(self._process))
        await self.ask(begin, protocol.Ready, START_TIMEOUT)

    async def ask(self, frame: protocol.ToHome, kind: type[A], timeout: float = ANSWER_TIMEOUT) -> A:
        """Tell it something that it answers.

        Raises
        ------
        Unavailable
            It is gone, or does not answer in time.
        PPaaSError
            It cannot.
        """
        async with self._one_at_a_time:
            self._write(frame)
            waiting = self._answer = asyncio.get_running_loop().create_future()
            try:
                async with asyncio.timeout(timeout):
                    answer = await waiting
            except TimeoutError as error:
                raise Unavailable(f"the process of local nodes did not answer in {timeout:g} s") from error
            finally:
                self._answer = None
                self._given_up += waiting.cancelled()  # its answer still comes, before that to the next
        if isinstance(answer, protocol.Failed):
            raise rebuild(answer.slug, answer.text)
        if not isinstance(answer, kind):
            raise Unavailable(f"the process of local nodes answered {type(answer).__name__}, not {kind.__name__}")
        return answer

    def tell(self, topic: str, payload: bytes, node: str = "") -> None:
        """Tell its nodes, or one alone, a message; a process that is gone hears nothing."""
        if self.alive:
            self._write(protocol.Tell(topic, msgspec.Raw(payload), node))

    async def call(self, service: str, request: bytes, timeout: float = CALL_TIMEOUT) -> msgspec.Raw:
        """Call a service of its nodes; return the response as JSON. Several calls may be under way at once.

        Raises
        ------
        Unavailable
            It is gone, or does not answer in time, or the node has left.
        PPaaSError
            What the node says.
        """
        number = next(self._numbers)
        self._write(protocol.Call(number, service, msgspec.Raw(request)))
        waiting: asyncio.Future[protocol.Replied] = asyncio.get_running_loop().create_future()
        self._calls[number] = waiting
        try:
            async with asyncio.timeout(timeout):
                replied = await waiting
        except TimeoutError as error:
            raise Unavailable(f"service {service!r} did not answer within {timeout:g} s") from error
        finally:
            del self._calls[number]
        if replied.slug:
            raise rebuild(replied.slug, replied.text)
        return replied.response

    def _write(self, frame: protocol.ToHome) -> None:
        if self._process is None or self._process.stdin is None or self._is_read_out:
            raise Unavailable("the process of local nodes is gone")
        self._process.stdin.write(protocol.line(frame))

    async def _read(self, process: Process) -> None:
        assert process.stdout is not None
        try:
            while told := await process.stdout.readline():
                self._take(protocol.from_home.decode(told))
        except (ConnectionError, msgspec.MsgspecError, ValueError) as error:
            logger.warning("the process of local nodes is given up: %s", error)
        finally:
            self._fail(Unavailable("the process of local nodes has ended"))
            self._ended()

    def _fail(self, error: Unavailable) -> None:
        for waiting in (self._answer, *self._calls.values()):
            if waiting is not None and not waiting.done():
                waiting.set_exception(error)

    def _take(self, frame: protocol.FromHome) -> None:
        if isinstance(frame, protocol.Said):
            self._said(frame)
        elif isinstance(frame, protocol.Replied):
            self._replied(frame)
        elif self._given_up:
            self._given_up -= 1
        elif self._answer is not None and not self._answer.done():
            self._answer.set_result(frame)

    def _replied(self, frame: protocol.Replied) -> None:
        waiting = self._calls.get(frame.call)
        if waiting is not None and not waiting.done():
            waiting.set_result(frame)

    async def stop(self) -> None:
        """End it, whatever it does."""
        if self._process is None:
            return
        with contextlib.suppress(ProcessLookupError):
            self._process.kill()
        await self._process.wait()
        if self._reading is not None:
            self._reading.cancel()
            await asyncio.gather(self._reading, return_exceptions=True)
