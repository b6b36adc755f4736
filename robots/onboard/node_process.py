"""Parent side of the executor process in which local nodes run."""

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
"""Time limit of the start [s]; the first start on a computer compiles the kernels."""
ANSWER_TIMEOUT = 5.0
"""Time limit of an answer [s]; a process that exceeds it counts as hung."""
CALL_TIMEOUT = 60.0
"""Time limit of a service call [s], as in the cloud."""


class NodeProcess:
    """Starts the executor process, sends it commands, and receives the messages of its nodes.

    Parameters
    ----------
    on_message : callable
        Called with each message that a node publishes.
    on_exit : callable
        Called once the process has exited.
    """

    def __init__(self, on_message: Callable[[protocol.Said], None], on_exit: Callable[[], None]) -> None:
        self._on_message = on_message
        self._on_exit = on_exit
        self._process: Process | None = None
        self._reading: asyncio.Task[None] | None = None
        self._answer: asyncio.Future[protocol.Answer] | None = None
        self._abandoned = 0
        self._one_at_a_time = asyncio.Lock()
        self._numbers = itertools.count(1)
        self._calls: dict[int, asyncio.Future[protocol.Replied]] = {}

    @property
    def alive(self) -> bool:
        """Whether the process runs."""
        return self._process is not None and self._process.returncode is None and not self._output_closed

    @property
    def pid(self) -> int | None:
        """Process id; None if the process was not started."""
        return self._process.pid if self._process is not None else None

    @property
    def _output_closed(self) -> bool:
        return self._reading is None or self._reading.done()

    async def start(self, begin: protocol.Begin) -> None:
        """Start the process and wait until it can take nodes.

        Raises
        ------
        Unavailable
            It exited, or was not ready in time.
        PPaaSError
            It rejected the configuration.
        """
        command = (sys.executable, "-m", executor.__name__)
        # A separate session: on Ctrl-C the robot's program first hands the nodes back, then stops this process.
        self._process = await asyncio.create_subprocess_exec(
            *command, stdin=PIPE, stdout=PIPE, limit=protocol.MAX_LINE, start_new_session=True
        )
        self._reading = asyncio.create_task(self._read(self._process))
        await self.ask(begin, protocol.ExecutorReady, START_TIMEOUT)

    async def ask(self, frame: protocol.ToExecutor, kind: type[A], timeout: float = ANSWER_TIMEOUT) -> A:
        """Send a command and return its answer.

        Raises
        ------
        Unavailable
            The process has exited, or did not answer in time.
        PPaaSError
            The command failed.
        """
        async with self._one_at_a_time:
            self._write(frame)
            waiting = self._answer = asyncio.get_running_loop().create_future()
            try:
                async with asyncio.timeout(timeout):
                    answer = await waiting
            except TimeoutError as error:
                raise Unavailable(f"the process of the local nodes did not answer within {timeout:g} s") from error
            finally:
                self._answer = None
                self._abandoned += waiting.cancelled()  # its late answer precedes that to the next command
        if isinstance(answer, protocol.NodeFailed):
            raise rebuild(answer.slug, answer.text)
        if not isinstance(answer, kind):
            raise Unavailable(
                f"the process of the local nodes answered {type(answer).__name__} instead of {kind.__name__}"
            )
        return answer

    def tell(self, topic: str, payload: bytes, node: str = "") -> None:
        """Send a message to all nodes, or to one; ignored if the process has exited."""
        if self.alive:
            self._write(protocol.Tell(topic, msgspec.Raw(payload), node))

    async def call(self, service: str, request: bytes, timeout: float = CALL_TIMEOUT) -> msgspec.Raw:
        """Call a service of its nodes; return the response as JSON. Several calls may be in progress at once.

        Raises
        ------
        Unavailable
            The process has exited or did not answer in time, or the node has left.
        PPaaSError
            The error that the node returned.
        """
        number = next(self._numbers)
        self._write(protocol.NodeCall(number, service, msgspec.Raw(request)))
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

    def _write(self, frame: protocol.ToExecutor) -> None:
        if self._process is None or self._process.stdin is None or self._output_closed:
            raise Unavailable("the process of the local nodes is not running")
        self._process.stdin.write(protocol.line(frame))

    async def _read(self, process: Process) -> None:
        assert process.stdout is not None
        try:
            while line := await process.stdout.readline():
                self._handle(protocol.from_executor.decode(line))
        except (ConnectionError, msgspec.MsgspecError, ValueError) as error:
            logger.warning("the output of the process of the local nodes is invalid: %s", error)
        finally:
            self._fail(Unavailable("the process of the local nodes has exited"))
            self._on_exit()

    def _fail(self, error: Unavailable) -> None:
        for waiting in (self._answer, *self._calls.values()):
            if waiting is not None and not waiting.done():
                waiting.set_exception(error)

    def _handle(self, frame: protocol.FromExecutor) -> None:
        if isinstance(frame, protocol.Said):
            self._on_message(frame)
        elif isinstance(frame, protocol.Replied):
            self._handle_reply(frame)
        elif self._abandoned:
            self._abandoned -= 1
        elif self._answer is not None and not self._answer.done():
            self._answer.set_result(frame)

    def _handle_reply(self, frame: protocol.Replied) -> None:
        waiting = self._calls.get(frame.call)
        if waiting is not None and not waiting.done():
            waiting.set_result(frame)

    async def stop(self) -> None:
        """Kill the process and wait until it has exited."""
        if self._process is None:
            return
        with contextlib.suppress(ProcessLookupError):
            self._process.kill()
        await self._process.wait()
        if self._reading is not None:
            self._reading.cancel()
            await asyncio.gather(self._reading, return_exceptions=True)
