"""Program that compiles all kernels into the cache, beside the containers of a running machine.

A cloud has many planners, and most robots use one. Compiling the kernels of all planners before the first container
takes minutes on a new computer; loading them all takes seconds at every start and memory in every container. So the
fork server loads the kernels that every container uses, and this program compiles the others into the cache, at low
priority. Those that a container waits for come first, at normal priority: containers do not compile them themselves.

`engine.runtimes.compilation.kernel_compiler` starts it, reads its progress from its standard output, one
``CompileReport`` a line, and writes the modules that are waited for to its standard input, a list of names a line.
``ppaas warm`` runs it for a person who waits: all kernels at normal priority.
"""

import sys
import threading
from pathlib import Path
from typing import BinaryIO

import msgspec

import ppaas
from engine.processes.helper_program import end_with, take_standard_output
from engine.runtimes.compilation import compile_pool, stamp, threading_layer
from engine.runtimes.compilation.stamp import ModuleNotes
from ppaas.decoding import from_json
from ppaas.kernel_cache.sources import kernel_files

STEP = 10
"""Number of modules after which the progress is printed for people."""

COMMAND = (sys.executable, "-W", stamp.QUIET, "-m", __spec__.name)


def main() -> None:
    """Compile all kernels on all processors, unless a note says that they are compiled.

    The first command-line argument, if any, is the id of the parent process, with which this process exits, and which
    reads the progress.
    """
    has_parent = len(sys.argv) > 1
    if has_parent:
        end_with(int(sys.argv[1]))
    root = Path(ppaas.__path__[0])
    layer = threading_layer.choose()
    if stamp.is_compiled(root, layer):
        return
    noted = stamp.stamp_file(root, layer)
    notes, output = ModuleNotes(noted), take_standard_output()
    report: compile_pool.Report = _Progress(output)
    if has_parent:
        report = _Printed(output)
        threading.Thread(target=_read_wanted, args=(notes,), daemon=True).start()
    stamp.note(noted, compile_pool.compile_all(_modules(root), notes, urgent=not has_parent, report=report))


def _read_wanted(notes: ModuleNotes) -> None:
    # Unbuffered: the interpreter cannot end while a thread holds the lock of a buffer.
    for line in open(sys.stdin.fileno(), "rb", buffering=0, closefd=False):  # noqa: SIM115
        notes.want(from_json(line, list[str]))


class _Printed:
    def __init__(self, output: BinaryIO) -> None:
        self._output = output
        self._last: compile_pool.CompileReport | None = None

    def __call__(self, report: compile_pool.CompileReport) -> None:
        if report != self._last:
            self._last = report
            self._output.write(msgspec.json.encode(report) + b"\n")
            self._output.flush()


class _Progress:
    def __init__(self, output: BinaryIO) -> None:
        self._output = output
        self._last = -1

    def __call__(self, report: compile_pool.CompileReport) -> None:
        done = len(report.compiled) + len(report.failed)
        if done >= self._last + STEP or (done > self._last and done == len(report.modules)):
            self._last = done
            self._output.write(f"kernels: {done} of {len(report.modules)} modules are compiled\n".encode())
            self._output.flush()


def _modules(root: Path) -> list[str]:
    """Return the kernel modules that have a ``warm`` function, the largest first: they take longest.

    They are found by their text. To import them takes seconds, and memory that this process needs for nothing else.
    """
    files = [file for file in kernel_files(root) if b"\ndef warm(" in file.read_bytes()]
    files.sort(key=lambda file: file.stat().st_size, reverse=True)
    return [".".join([root.name, *file.relative_to(root).with_suffix("").parts]) for file in files]


if __name__ == "__main__":
    main()
