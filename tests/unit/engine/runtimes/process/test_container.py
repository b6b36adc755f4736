"""Moving a running process to other CPUs, with all its threads."""

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

from engine.runtimes.process.container import move_threads

BUSY = """
import hashlib, threading
def burn():
    while True:
        hashlib.pbkdf2_hmac("sha256", b"x", b"y", 20000)  # releases the interpreter's lock
threads = [threading.Thread(target=burn) for _ in range(3)]
[thread.start() for thread in threads]
print("busy", flush=True)
"""
SECONDS = 0.5


@pytest.fixture
def busy() -> Iterator[int]:
    with subprocess.Popen([sys.executable, "-c", BUSY], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None and process.stdout.readline() == b"busy\n"
        yield process.pid
        process.kill()


def cpus_of(pid: int) -> list[set[int]]:
    return [os.sched_getaffinity(int(task.name)) for task in Path(f"/proc/{pid}/task").iterdir()]


def test_all_threads_move_to_a_cpu_and_back(busy: int) -> None:
    every = os.sched_getaffinity(0)
    one = min(every)
    move_threads(busy, (one,))
    assert cpus_of(busy) == [{one}] * 4
    move_threads(busy, tuple(every))
    assert cpus_of(busy) == [every] * 4


def test_three_busy_threads_on_one_cpu_use_no_more_than_one(busy: int) -> None:
    move_threads(busy, (min(os.sched_getaffinity(0)),))
    process = psutil.Process(busy)
    began, before = time.monotonic(), sum(process.cpu_times()[:2])
    time.sleep(SECONDS)
    used, took = sum(process.cpu_times()[:2]) - before, time.monotonic() - began
    assert used <= 1.15 * took  # the kernel counts CPU time in hundredths of a second


def test_exited_process_is_ignored() -> None:
    with subprocess.Popen([sys.executable, "-c", ""]) as process:
        process.wait()
    move_threads(process.pid, (0,))
