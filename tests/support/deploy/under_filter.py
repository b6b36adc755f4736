"""Run a program under the system calls that a unit of systemd allows: ``python under_filter.py UNIT COMMAND ...``."""

import errno
import os
import re
import subprocess
import sys
from pathlib import Path

import pyseccomp


def calls(name: str) -> set[str]:
    """Return the system calls of a set of systemd, such as ``@system-service``, or the one of this name."""
    if not name.startswith("@"):
        return {name}
    command = ["systemd-analyze", "syscall-filter", name]
    lines = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()[1:]
    inside = [line.strip() for line in lines if line.strip() and not line.strip().startswith("#")]
    return set().union(*map(calls, inside))


def allowed(unit: str) -> set[str]:
    """Return the calls that the filters of a unit allow, one after the other, as systemd.exec(5) defines it."""
    found = calls("@default")
    for value in re.findall(r"^SystemCallFilter=(.*)$", unit, re.MULTILINE):
        listed = set().union(*map(calls, value.removeprefix("~").split()))
        found = found - listed if value.startswith("~") else found | listed
    return found | {"execve"}


def main() -> None:
    """Set the filter, and become the program."""
    unit, *command = sys.argv[1:]
    limits = pyseccomp.SyscallFilter(pyseccomp.ERRNO(errno.EPERM))
    for name in sorted(allowed(Path(unit).read_text())):
        try:
            limits.add_rule(pyseccomp.ALLOW, name)
        except OSError:  # a call that this processor does not have
            continue
    limits.load()
    os.execvp(command[0], command)


if __name__ == "__main__":
    main()
