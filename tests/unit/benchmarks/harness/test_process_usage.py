"""Memory and CPU time of processes, from ``/proc``."""

import subprocess
import sys

import pytest

from benchmarks.harness.process_usage import cpu_seconds, memory_of


def test_private_memory_of_a_process_is_counted() -> None:
    hold = "print(0, flush=True); input(); held = b'1' * 40_000_000; print(1, flush=True); input()"
    command = [sys.executable, "-c", hold]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdin is not None and process.stdout is not None
        process.stdout.readline()
        before = memory_of(process.pid)
        process.stdin.write(b"\n")
        process.stdin.flush()
        process.stdout.readline()
        after = memory_of(process.pid)
        process.communicate(b"\n")
    assert after.private - before.private == pytest.approx(40.0, rel=0.05)
    assert after.pss >= after.private
    assert after.shared_map == 0.0


def test_the_memory_of_an_exited_process_is_an_error() -> None:
    process = subprocess.Popen([sys.executable, "-c", "pass"])
    process.wait()
    with pytest.raises(OSError):
        memory_of(process.pid)


def test_cpu_time_is_measured_by_kind_of_process() -> None:
    busy = """
import time
while time.process_time() < 0.3: pass
print(time.process_time(), flush=True)
input()
"""
    code = f"""
import subprocess, sys, time
child = subprocess.Popen([sys.executable, "-c", {busy!r}], stdout=subprocess.PIPE)
print(child.stdout.readline().decode().strip(), time.process_time(), flush=True)
child.wait()
"""
    with subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as web:
        assert web.stdout is not None
        by_child, by_web = map(float, web.stdout.readline().split())
        used = cpu_seconds(web.pid, set())
        web.communicate(b"\n")
    assert used["containers"] == 0.0
    # A start costs more CPU on a busy machine, so each process says its own; the kernel counts in steps of 10 ms.
    assert used["machine"] == pytest.approx(by_child, abs=0.05)
    assert used["web"] == pytest.approx(by_web, abs=0.05)
