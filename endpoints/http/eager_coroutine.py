"""Coroutines that are begun at once: most need not wait, and then nothing need be set up for those that do."""

from collections.abc import Coroutine, Generator
from typing import Any, Generic, TypeVar

T = TypeVar("T")


class EagerCoroutine(Generic[T]):
    """A coroutine, run to where it first waits. One that waited must be awaited, in the task that began it.

    Parameters
    ----------
    work : coroutine

    Attributes
    ----------
    done : bool
        It did not wait: what awaits it gets its result at once.
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
        """Return its result, or raise what it raises."""
        while not self.done:
            try:
                sent = yield self._awaited
            except BaseException as error:  # noqa: BLE001  # it is the coroutine's to answer
                self._throw(error)
            else:
                self._step(sent)
        return self._result
