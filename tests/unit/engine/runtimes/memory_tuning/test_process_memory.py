"""Gaps are filled, free memory is returned, and code is compacted."""

import gc
import subprocess
import sys
import threading

import pytest

from engine.runtimes.memory_tuning import process_memory
from tests.support.sources import ROOT


def run(code: str) -> str:
    done = subprocess.run([sys.executable, "-c", code], check=True, cwd=ROOT, env={}, capture_output=True, text=True)
    return done.stdout


def test_memory_freed_by_a_thread_is_returned():
    code = """
import threading
import numpy as np
from engine.runtimes.memory_tuning import process_memory
def resident():
    return int(open("/proc/self/statm").read().split()[1]) * 4096
def work():
    for size in (30, 20, 10):
        np.ones(size << 17)
process_memory.trim_early()
before = resident()
thread = threading.Thread(target=work)
thread.start(); thread.join()
print(resident() - before)
"""
    assert int(run(code)) < 2 << 20


def test_free_memory_between_used_blocks_is_returned():
    code = """
from engine.runtimes.memory_tuning import process_memory
def resident():
    return int(open("/proc/self/statm").read().split()[1]) * 4096
blocks = [bytes(50_000) for _ in range(400)]
del blocks[:-1]
before = resident()
process_memory.trim()
print(before - resident())
"""
    assert int(run(code)) > 10 << 20


ALLOCATE = """
import ctypes, sys
from engine.runtimes.memory_tuning import process_memory
allocate, free = {functions}
allocate.restype, allocate.argtypes = ctypes.c_void_p, [ctypes.c_size_t]
free.restype, free.argtypes = None, [ctypes.c_void_p]
blocks = [allocate({size}) for _ in range(2000)]
for block in blocks[::2]:
    free(block)
if "fill" in sys.argv:
    assert 1000 * {size} <= process_memory.fill() < 100 << 20
shared = {{block // 4096 for block in blocks}}
print(sum(allocate({size}) // 4096 in shared for _ in range(500)))
"""

INTERPRETER = "ctypes.pythonapi.PyObject_Malloc, ctypes.pythonapi.PyObject_Free"
LIBRARY = "ctypes.CDLL(None).malloc, ctypes.CDLL(None).free"
BLOCKS = [(INTERPRETER, 48), (INTERPRETER, 512), (LIBRARY, 600), (LIBRARY, 9000)]


@pytest.mark.parametrize(("functions", "size"), BLOCKS)
def test_new_blocks_are_not_placed_between_old_ones(functions, size):
    def between(*arguments: str) -> int:
        command = [sys.executable, "-c", ALLOCATE.format(functions=functions, size=size), *arguments]
        return int(subprocess.run(command, check=True, capture_output=True, text=True).stdout)

    assert between() > 400
    assert between("fill") < 20


@pytest.fixture(autouse=True)
def _thawed():
    """Let the garbage collector list the objects of this file, which are frozen after the collection of tests."""
    gc.unfreeze()
    yield
    gc.freeze()


def cold():
    return lambda: "cold"


def outer():
    def inner(number):
        return [number * each for each in (1, 2)]

    return inner


def counted(most):
    yield from range(most)


class Thing:
    def method(self):
        return outer()(2)


def code_in(code, name):
    return next(each for each in code.co_consts if getattr(each, "co_name", None) == name)


def test_only_code_that_ran_is_copied_with_code_defined_in_it():
    functions = [outer, Thing.method, counted]
    before, others = [each.__code__ for each in functions], [cold.__code__, code_in.__code__]
    inner = code_in(outer.__code__, "inner")
    assert (
        process_memory.compact(lambda: (Thing().method(), list(counted(3)))) >= 5
    )  # a list's own code is one of its own
    assert all(function.__code__ is not code for function, code in zip(functions, before, strict=True))
    assert [each.__code__ for each in functions] == before
    assert code_in(outer.__code__, "inner") is not inner
    assert [cold.__code__, code_in.__code__] == others
    assert cold.__code__ is others[0]
    assert code_in.__code__ is others[1]
    assert Thing().method() == [2, 4]
    assert list(counted(3)) == [0, 1, 2]


def test_code_of_other_threads_is_copied_and_profiling_ends():
    def in_thread():
        started = threading.Thread(target=target)
        started.start()
        started.join()

    def target():
        return None

    before = target.__code__
    process_memory.compact(in_thread)
    assert target.__code__ is not before
    assert threading.getprofile() is None
