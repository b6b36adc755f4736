"""Program that checks robot files: reads ``CloneToCheck`` as lines of JSON, and writes the faults of each as a line.

An empty line says first that it is ready.

Its arguments are the permitted third-party plug-ins as a JSON array of ``group:name``, where ``null`` permits all, the
process that it ends with, and the folder for temporary files, which its parent removes.
"""

import os
import sys
from pathlib import Path
from typing import BinaryIO

import msgspec

from engine.processes.helper_program import end_with, take_standard_output
from engine.specs.clone_to_check import CloneToCheck
from ppaas.decoding import from_json
from ppaas.log_lines import log_lines
from ppaas.plugins import permit_only

NICE = 5
"""Addition to the nice value: robots' containers come first."""


def main(allowed: str, parent: str, folder: str) -> None:
    """Check files until standard input ends."""
    end_with(int(parent))
    os.nice(NICE)
    answers = take_standard_output()
    log_lines("%(levelname)s robot check %(name)s: %(message)s", process="robot check")
    names = from_json(allowed, list[str] | None)
    if names is not None:
        permit_only(names)
    from engine.container.clone_check import CloneCheck  # noqa: PLC0415 - loads plug-ins

    check, decoder = CloneCheck(Path(folder)), msgspec.json.Decoder(CloneToCheck)
    _write(answers, b"")
    for line in sys.stdin.buffer:
        _write(answers, msgspec.json.encode(check.faults(decoder.decode(line))))


def _write(answers: BinaryIO, line: bytes) -> None:
    answers.write(line + b"\n")
    answers.flush()


if __name__ == "__main__":
    main(*sys.argv[1:])
