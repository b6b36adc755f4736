import subprocess
import sys

import pytest

from engine.runtimes.memory_tuning import allocator
from tests.support.sources import ROOT


def run(code: str, **environment: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", code], check=True, cwd=ROOT, env=environment, capture_output=True, text=True
    )
    return done.stdout


def test_unused_extras_are_not_found_for_a_while_and_then_are():
    code = """
from engine.runtimes import memory
with memory.without_extras():
    for name in memory.UNUSED_EXTRAS:
        try:
            __import__(name)
        except ImportError:
            print("no", name)
import typing_extensions, yaml
"""
    assert run(code).split() == [word for name in allocator.UNUSED_EXTRAS for word in ("no", name)]


def test_an_extra_that_is_loaded_already_stays(monkeypatch):
    monkeypatch.setitem(sys.modules, "yaml", sys)
    with allocator.without_extras():
        assert sys.modules["yaml"] is sys
    assert sys.modules["yaml"] is sys


def test_what_a_thread_freed_is_given_back():
    code = """
import threading
import numpy as np
from engine.runtimes import memory
def resident():
    return int(open("/proc/self/statm").read().split()[1]) * 4096
def work():
    for size in (30, 20, 10):
        np.ones(size << 17)
memory.give_back_early()
before = resident()
thread = threading.Thread(target=work)
thread.start(); thread.join()
print(resident() - before)
"""
    assert int(run(code)) < 2 << 20


def test_what_is_free_between_what_is_kept_is_given_back():
    code = """
from engine.runtimes import memory
def resident():
    return int(open("/proc/self/statm").read().split()[1]) * 4096
blocks = [bytes(50_000) for _ in range(400)]
del blocks[:-1]
before = resident()
memory.give_back()
print(before - resident())
"""
    assert int(run(code)) > 10 << 20


@pytest.mark.parametrize(("begun", "starts"), [({}, "first\nsecond\n"), ({"PPAAS_BEGUN_ANEW": "1"}, "second\n")])
def test_a_program_begins_anew_once_with_the_environment_it_had(begun, starts):
    code = """
import os
from engine.runtimes import memory
environment = dict(os.environ)
os.environ["KIND"] = "changed"
print("first" if "PPAAS_BEGUN_ANEW" not in environment else "second", flush=True)
assert environment["KIND"] == "given"
memory.begin_anew(environment)
"""
    assert run(code, KIND="given", **begun) == starts
