"""Code compaction: copies the code that containers run to adjacent memory, before they are forked.

The interpreter writes into code objects as it runs them: call counters and inline caches. Code objects are in memory
in the order in which modules were imported, so those that a container runs are scattered among those that it never
runs, and each function that it calls costs it a private copy of a page or two. Code objects that are copied one after
the other take a fifth of these pages.
"""

import gc
import sys
import threading
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from types import CodeType, FrameType, FunctionType

from engine.runtimes.memory_tuning.switch import LEAN


def compact(run: Callable[[], object]) -> int:
    """Run a function, replace all code that it ran by copies in all functions, and return the number of copies.

    The inline caches of the interpreter are not copied. Each container fills them again, on pages that it would write
    to anyway. Running everything again here would save 0.1 MB and take longer than all other steps.
    """
    if not LEAN:
        run()
        return 0
    with _recorded() as ran:
        run()
    functions = [each for each in gc.get_objects() if type(each) is FunctionType]  # a proxy would pass isinstance()
    copies: dict[int, CodeType] = {}
    for function in functions:
        code = _copied(function.__code__, ran, copies)
        if code is not function.__code__:
            function.__code__ = code
    return len(copies)


@contextmanager
def _recorded() -> Iterator[Collection[int]]:
    """Record the ids of the code objects that run, in this thread and in threads that are started meanwhile."""
    ran: dict[int, CodeType] = {}  # keeps the code alive, so that its id is not reused

    def note(frame: FrameType, _event: str, _argument: object) -> None:
        ran[id(frame.f_code)] = frame.f_code

    threading.setprofile(note)
    sys.setprofile(note)
    try:
        yield ran
    finally:
        sys.setprofile(None)
        threading.setprofile(None)


def _copied(code: CodeType, ran: Collection[int], copies: dict[int, CodeType]) -> CodeType:
    """Return the copy of a code object, or itself if neither it nor code defined in it ran."""
    if id(code) not in copies:
        constants = tuple(_copied(c, ran, copies) if isinstance(c, CodeType) else c for c in code.co_consts)
        if id(code) not in ran and all(a is b for a, b in zip(constants, code.co_consts, strict=True)):
            return code
        copies[id(code)] = code.replace(co_consts=constants)
    return copies[id(code)]
