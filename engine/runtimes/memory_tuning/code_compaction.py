"""Moves the code that containers run side by side, before they are forked.

The interpreter writes into code as it runs it: it counts calls, and notes what it has met. Code lies in memory in the
order in which modules were loaded, so what a container runs is strewn among what it never does, and each function that
it calls costs it a copy of a page or two. Copies that are made one after the other lie on a fifth of these pages.
"""

import gc
import sys
import threading
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from types import CodeType, FrameType, FunctionType

from engine.runtimes.memory_tuning.switch import LEAN


def compact(run: Callable[[], object]) -> int:
    """Run something, and give all functions copies of such code as that ran; return how many copies were made.

    What the interpreter has learnt of the code is not copied. Each container learns it again, on pages that it would
    write to anyway; to run all once more here saves it 0.1 MB and takes longer than all else.
    """
    if not LEAN:
        run()
        return 0
    with _noted() as ran:
        run()
    functions = [each for each in gc.get_objects() if type(each) is FunctionType]  # a proxy would say it were one
    copies: dict[int, CodeType] = {}
    for function in functions:
        code = _copied(function.__code__, ran, copies)
        if code is not function.__code__:
            function.__code__ = code
    return len(copies)


@contextmanager
def _noted() -> Iterator[Collection[int]]:
    """Note the ids of code that this thread runs, and each that is started meanwhile."""
    ran: dict[int, CodeType] = {}  # and the code: no other is to get the id of one that is gone

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
    """Return the copy of some code, or itself where neither it nor what is defined in it was run."""
    if id(code) not in copies:
        constants = tuple(_copied(c, ran, copies) if isinstance(c, CodeType) else c for c in code.co_consts)
        if id(code) not in ran and all(a is b for a, b in zip(constants, code.co_consts, strict=True)):
            return code
        copies[id(code)] = code.replace(co_consts=constants)
    return copies[id(code)]
