"""Interface of one end of a link: the methods that the other end may call, and proxies whose methods make these calls.

An interface is a class whose methods are all ``async``, and whose annotations msgspec encodes; errors may be passed,
too. Its name is part of the names of its methods on the wire, so that interfaces need not know each other's methods.
"""

import inspect
from collections.abc import Callable, Coroutine
from functools import cache, partial
from typing import Any, Protocol, TypeVar, cast, get_type_hints

import msgspec

from engine.protocols.refusals import Refusal, error_of, refusal_of
from ppaas.decoding import converted
from ppaas.errors import PPaaSError

F = TypeVar("F", bound=Callable[..., Any])

_WIRE_NAME, _NOTICE = "wire_name", "is_notice"


def wire_name(name: str) -> Callable[[F], F]:
    """Give a method a name on the wire that no other interface and no later release has another meaning for."""

    def named(function: F) -> F:
        function.__dict__[_WIRE_NAME] = name
        return function

    return named


def notice(function: F) -> F:
    """Mark a method that is called without waiting for its end; the call is lost if the other end is not reachable."""
    function.__dict__[_NOTICE] = True
    return function


def is_notice(function: Callable[..., Any]) -> bool:
    """Return whether a method is marked as a notice."""
    return _NOTICE in function.__dict__


class Method:
    """Codec of a method.

    Parameters
    ----------
    function : callable
        The method, as the class has it.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        hints = get_type_hints(function)
        _, *parameters = inspect.signature(function).parameters.values()
        kinds = tuple(hints[parameter.name] for parameter in parameters)
        self.name: str = function.__dict__.get(_WIRE_NAME, function.__qualname__)
        self.attribute = function.__name__
        self._signature = inspect.Signature(parameters)
        self._count = len(parameters)
        self.arguments: msgspec.msgpack.Decoder[tuple[Any, ...]] = msgspec.msgpack.Decoder(
            tuple[kinds],  # type: ignore[valid-type]
            dec_hook=_decoded_error,
        )
        self.result: msgspec.msgpack.Decoder[Any] = msgspec.msgpack.Decoder(hints["return"], dec_hook=_decoded_error)

    def packed(self, args: tuple[Any, ...], named: dict[str, Any]) -> msgspec.Raw:
        """Return the arguments of a call as MessagePack, in the order of the method, with its defaults."""
        if named or len(args) != self._count:
            bound = self._signature.bind(*args, **named)
            bound.apply_defaults()
            args = bound.args
        return packed(args)


@cache
def method_of(function: Callable[..., Any]) -> Method:
    """Return the codec of a method, given as the class has it."""
    return Method(function)


@cache
def methods_of(interface: type) -> tuple[Method, ...]:
    """Return the methods of an interface."""
    return tuple(
        method_of(function)
        for name, function in inspect.getmembers(interface, inspect.iscoroutinefunction)
        if not name.startswith("_")
    )


def packed(value: object) -> msgspec.Raw:
    """Return a value as MessagePack."""
    return msgspec.Raw(_encoder.encode(value))


def _encoded_error(value: object) -> Refusal:
    if isinstance(value, PPaaSError):
        return refusal_of(value)
    raise NotImplementedError(f"a call cannot pass {type(value).__name__}")


def _decoded_error(kind: type, value: object) -> PPaaSError:
    if issubclass(kind, PPaaSError):
        return error_of(converted(value, Refusal))
    raise NotImplementedError(f"a call cannot pass {kind.__name__}")


_encoder = msgspec.msgpack.Encoder(enc_hook=_encoded_error)

I = TypeVar("I")  # noqa: E741 - an interface


class CallLink(Protocol):
    """End of a link that calls the methods of the other end."""

    async def call(self, method: Callable[..., Coroutine[Any, Any, Any]], /, *args: Any, **named: Any) -> Any:
        """Call a method, given as its interface has it, and return its result."""
        ...

    def tell(self, method: Callable[..., Coroutine[Any, Any, None]], /, *args: Any, **named: Any) -> object:
        """Call a method without waiting."""
        ...


class _Remote:
    def __init__(self, interface: Callable[..., object], link: CallLink) -> None:
        self._interface = interface
        self._link = link

    def __getattr__(self, name: str) -> Callable[..., Coroutine[Any, Any, Any]]:
        method = getattr(self._interface, name, None)
        if name.startswith("_") or not inspect.iscoroutinefunction(method):
            raise AttributeError(f"{self._interface} has no method {name!r}", name=name, obj=self)
        calls = partial(self._tell if is_notice(method) else self._link.call, method)
        self.__dict__[name] = calls  # found there from now on
        return calls

    async def _tell(self, method: Callable[..., Coroutine[Any, Any, None]], *args: Any, **named: Any) -> None:
        self._link.tell(method, *args, **named)


def remote(interface: Callable[..., I], link: CallLink) -> I:
    """Return an object that calls the methods of an interface at the other end of a link.

    Parameters
    ----------
    interface : type
        Interface that the other end serves.
    link : CallLink
    """
    return cast(I, _Remote(interface, link))
