"""Eagerly started coroutines: those that finish without waiting need no timeout or task."""

from collections.abc import Coroutine, Generator
from typing import Any, Generic, TypeVar

T = TypeVar("T")


class EagerCoroutine(Generic[T]):
    """Coroutine that runs at once up to its first suspension; if it suspends, the task that created it must await it.

    Parameters
    ----------
    work : coroutine
        The coroutine to run.

    Attributes
    ----------
    done : bool
        Whether it finished; awaiting it then returns at once.
    """

    def __init__(self, work: Coroutine[Any, Any, T]) -> None:
        self._work = work
        self._result: T
        self._awaited: object = None
        self.done = False
        self._step(None)

    def _step(self, sent: object) -> None:
        try:
            self._awaited = self._work.send(sent)
        except StopIteration as end:
            self._result, self.done = end.value, True

    def _throw(self, error: BaseException) -> None:
        try:
            self._awaited = self._work.throw(error)
        except StopIteration as end:
            self._result, self.done = end.value, True

    def __await__(self) -> Generator[object, object, T]:
        """Return the result of the coroutine, or raise its exception."""
        while not self.done:
            try:
                sent = yield self._awaited
            except BaseException as error:  # noqa: BLE001  # passed into the coroutine, which handles it
                self._throw(error)
            else:
                self._step(sent)
        return self._result
