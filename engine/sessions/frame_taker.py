"""Frame taker: executes the frames of one client in order, each once."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from itertools import chain

from engine.protocols.session_frames import NumberedFrame
from engine.sessions.plan_permits import PermitAwaited
from engine.sessions.unsettled import UnsettledFrames
from ppaas.wire import operations
from ppaas.wire.rosbridge import RosbridgeSession

Execute = Callable[[operations.ClientOperation | operations.RefusedOperation], None]
"""Executes an operation; raises ``PermitAwaited`` if it must wait for a permit."""


class FrameTaker:
    """Decodes the frames of a client, and executes their operations.

    An operation that waits for a permit lets the later frames wait, too.

    Parameters
    ----------
    wire : RosbridgeSession
        State of the rosbridge protocol.
    execute : callable
        Executes an operation.
    unsettled : UnsettledFrames
        Frames of the client.
    ask : callable
        Called when an operation waits for a permit; `resume` must follow.
    """

    def __init__(
        self, wire: RosbridgeSession, execute: Execute, unsettled: UnsettledFrames, ask: Callable[[], None]
    ) -> None:
        self._wire = wire
        self._execute_one = execute
        self._unsettled = unsettled
        self._ask = ask
        self._suspended: Iterator[operations.ClientOperation | operations.RefusedOperation] | None = None
        self._current = NumberedFrame(0, b"")
        self._waiting: deque[NumberedFrame] = deque()

    def waiting(self) -> list[NumberedFrame]:
        """Return the frames that are not executed yet, in order; the first has an operation that waits."""
        return [self._current, *self._waiting] if self.waits else []

    @property
    def waits(self) -> bool:
        """Whether an operation waits for a permit."""
        return self._suspended is not None

    def take(self, frame: NumberedFrame) -> None:
        """Execute a frame, after those that wait."""
        if self.waits:
            self._waiting.append(frame)
        else:
            self._run(frame)

    def resume(self) -> None:
        """Execute the operation that waits for a permit, and the frames after it."""
        suspended, self._suspended = self._suspended, None
        if suspended is not None:
            self._execute(suspended)
        while self._waiting and not self.waits:
            self._run(self._waiting.popleft())

    def _run(self, frame: NumberedFrame) -> None:
        self._current = frame
        self._unsettled.begin(frame)
        receive = self._wire.receive_binary if frame.binary else self._wire.receive
        operation = receive(frame.content)
        self._unsettled.gather(self._wire.incomplete)
        if isinstance(operation, operations.Fragment):
            self._unsettled.wait_for_rest(operation.id)
        elif isinstance(operation, operations.RefusedOperation) and operation.parts:
            self._execute(map(self._wire.receive, operation.parts))
        else:
            self._execute(iter((operation,)))

    def _execute(self, waiting: Iterable[operations.ClientOperation | operations.RefusedOperation]) -> None:
        rest = iter(waiting)
        for operation in rest:
            try:
                self._execute_one(operation)
            except PermitAwaited:
                self._suspended = chain((operation,), rest)
                self._ask()
                return
        self._unsettled.end()
