"""Compiled kernels of stores are loaded without waiting for other processes."""

import subprocess
import sys

from engine.processes.disk_notes import exclusive
from engine.runtimes.compilation import kernel_compiler
from tests.support.sources import ROOT

PREPARE = """
from engine.runtimes.compilation import kernel_compiler
from engine.runtimes.compilation import kernel_modules

recorder = kernel_modules.record_compilations()
kernel_compiler.prepare()
print(len(recorder.buffer))
"""


def compiled_by_another_process() -> int:
    """Prepare in a separate process; return the number of kernels that it compiled."""
    command = [sys.executable, "-c", PREPARE]
    result = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True, timeout=120)
    return int(result.stdout)


def test_compiled_kernels_are_loaded_without_waiting_for_a_compiler() -> None:
    compiled_by_another_process()
    with exclusive(kernel_compiler.stamp_of_stores().with_suffix(".lock")):
        assert compiled_by_another_process() == 0
