"""Objects of another process: each method of theirs is a call over a link."""

import inspect
from collections.abc import Callable, Coroutine
from functools import partial
from typing import Any, Protocol, TypeVar, cast

from engine.calls.interface import is_notice

I = TypeVar("I")  # noqa: E741 - an interface


class Link(Protocol):
    """End of a link that calls the methods of the other end."""

    async def call(self, method: Callable[..., Coroutine[Any, Any, Any]], /, *args: Any, **named: Any) -> Any:
        """Call a method, given as its interface has it, and return its result."""
        ...

    def tell(self, method: Callable[..., Coroutine[Any, Any, None]], /, *args: Any, **named: Any) -> object:
        """Call a method without waiting."""
        ...


class _Remote:
    def __init__(self, interface: Callable[..., object], link: Link) -> None:
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


def remote(interface: Callable[..., I], link: Link) -> I:
    """Return an object that calls the methods of an interface at the other end of a link.

    Parameters
    ----------
    interface : type
        Interface that the other end serves.
    link : Link
    """
    return cast(I, _Remote(interface, link))
