import gc
import threading

import pytest

from engine.runtimes.memory_tuning import process_memory


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
