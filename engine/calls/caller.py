"""Caller: one end of a link by which two processes call each other's methods."""

import asyncio
import itertools
import logging
from collections.abc import Callable, Coroutine, Mapping
from typing import Any, Concatenate, ParamSpec, TypeVar

import msgspec

from engine.calls.interface import Method, method_of, methods_of, packed
from engine.processes.background import Background
from engine.protocols.framing import FrameStream
from engine.protocols.refusals import Refusal, error_of, refusal_of
from ppaas.errors import InvalidInput, NotPermitted, PPaaSError, Unavailable
from ppaas.tracing.spans import LONGEST, served, traceparent


class Call(msgspec.Struct, tag="call"):
    """Call of a method; ``arguments`` is an array of MessagePack, ``trace`` the ``traceparent`` of the caller."""

    number: int
    method: str
    arguments: msgspec.Raw
    trace: str = ""


class Notice(msgspec.Struct, tag="notice"):
    """Call of a method without an answer."""

    method: str
    arguments: msgspec.Raw


class Result(msgspec.Struct, tag="result"):
    """Result of a call, as MessagePack."""

    number: int
    value: msgspec.Raw


class Failure(msgspec.Struct, tag="failure"):
    """Error of a call."""

    number: int
    refusal: Refusal


Frame = Call | Notice | Result | Failure

logger = logging.getLogger(__name__)

P = ParamSpec("P")
R = TypeVar("R")


class Caller:
    """Calls the methods of the other end, and serves its calls.

    A call runs to its end on the other side, also if nobody waits for its result any more.

    Parameters
    ----------
    stream : FrameStream
        The link.
    served : mapping of type to object
        Interfaces with the methods that the other end may call, and the objects that run them.

    Attributes
    ----------
    admits : callable
        Returns whether the other end may call a method now, given its name.
    """

    def __init__(self, stream: FrameStream[Frame], served: Mapping[type, object]) -> None:
        self._stream = stream
        self._methods: dict[str, tuple[Method, Callable[..., Coroutine[Any, Any, Any]]]] = {
            method.name: (method, getattr(part, method.attribute))
            for interface, part in served.items()
            for method in methods_of(interface)
        }
        self._numbers = itertools.count(1)
        self._waiting: dict[int, asyncio.Future[msgspec.Raw]] = {}
        self._background = Background()
        self._lost = False
        self.admits: Callable[[str], bool] = lambda _: True

    async def call(
        self, method: Callable[Concatenate[Any, P], Coroutine[Any, Any, R]], *args: P.args, **named: P.kwargs
    ) -> R:
        """Call a method of the other end, given as its interface has it, and return its result.

        Raises
        ------
        Unavailable
            The link is lost.
        PPaaSError
            The error that the method raised.
        """
        if self._lost:
            raise _lost()
        number = next(self._numbers)
        answered = self._waiting[number] = asyncio.get_running_loop().create_future()
        codec = method_of(method)
        self._stream.write(Call(number, codec.name, codec.packed(args, named), traceparent()))
        try:
            result: R = codec.result.decode(await answered)
            return result
        finally:
            self._waiting.pop(number, None)

    def tell(
        self, method: Callable[Concatenate[Any, P], Coroutine[Any, Any, None]], *args: P.args, **named: P.kwargs
    ) -> None:
        """Call a method of the other end without waiting; lost if the link is."""
        codec = method_of(method)
        self._stream.write(Notice(codec.name, codec.packed(args, named)))

    async def serve(self) -> None:
        """Serve the other end until the link is lost.

        Raises
        ------
        MalformedMessage, MessageTooLarge
            The other end violates the protocol.
        """
        try:
            await self._stream.each(self._take)
        finally:
            self._lost = True
            for answered in self._waiting.values():
                if not answered.done():
                    answered.set_exception(_lost())
            await self._background.cancel()

    def hang_up(self) -> None:
        """Close the link."""
        self._stream.abort()

    def _take(self, frame: Frame) -> bool:
        match frame:
            case Call():
                self._background.run(self._answer(frame))
            case Notice():
                self._background.run(self._heed(frame))
            case Result():
                self._end(frame.number, frame.value)
            case Failure():
                self._end(frame.number, error_of(frame.refusal))
        return True

    def _end(self, number: int, outcome: msgspec.Raw | PPaaSError) -> None:
        answered = self._waiting.get(number)
        if answered is None or answered.done():
            return
        if isinstance(outcome, PPaaSError):
            answered.set_exception(outcome)
        else:
            answered.set_result(outcome)

    async def _answer(self, call: Call) -> None:
        try:
            with served(call.method[:LONGEST], call.trace):
                result = await self._run(call.method, call.arguments)
        except PPaaSError as error:
            self._stream.write(Failure(call.number, refusal_of(error)))
        except Exception as error:
            logger.exception("a call of %r failed", call.method)
            internal = PPaaSError(f"internal error: {type(error).__name__}")
            self._stream.write(Failure(call.number, refusal_of(internal)))
        else:
            self._stream.write(Result(call.number, packed(result)))

    async def _heed(self, notice: Notice) -> None:
        try:
            await self._run(notice.method, notice.arguments)
        except PPaaSError as error:
            logger.warning("a notice %r failed: %s", notice.method, error)

    async def _run(self, name: str, arguments: msgspec.Raw) -> Any:
        known = self._methods.get(name)
        if known is None:
            raise InvalidInput(f"the other process calls {name[:64]!r}, which this release does not have")
        if not self.admits(name):
            raise NotPermitted(f"the other process may not call {name!r} before it has registered")
        method, run = known
        try:
            decoded = method.arguments.decode(arguments)
        except msgspec.DecodeError as error:
            raise InvalidInput(f"the arguments of {name!r} are those of another release: {error}") from error
        return await run(*decoded)


def _lost() -> Unavailable:
    return Unavailable("the process that decides about containers is not reachable at the moment; try again")
