import subprocess
import sys

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
