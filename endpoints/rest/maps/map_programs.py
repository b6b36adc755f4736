"""Map programs: separate processes that check, draw and merge maps, with one set of limits.

Kernels load slowly, and an invalid or large file may need much memory. A program writes its result or its error to
standard output as JSON.
"""

import json
import logging
import os
import resource
import subprocess
import sys
from collections.abc import Callable, Collection, Sequence
from typing import Any

from ppaas.errors import PPaaSError, Unavailable, rebuild

logger = logging.getLogger(__name__)

MEMORY = 4 << 30
"""Memory limit of a program [bytes]."""

NICE = 5
"""Addition to the nice value of a program: robots' containers come first."""

CHECK_SECONDS = 120.0
"""Time limit of the check of a file [s]. The largest take some seconds, the first one longer to compile kernels."""

MAKE_SECONDS = 240.0
"""Time limit of a program that draws or merges maps [s]. Drives of 400 m take 2 to 5 s, the first one longer."""

_MOST_LOGGED = 2000
"""Length of the part of a program's standard error that is logged [characters]."""


def run_program(
    module: str, arguments: Sequence[str], failure: str, seconds: float, *, inherited: Collection[int] = ()
) -> Any:
    """Run a program; return its result. Blocks.

    Parameters
    ----------
    module : str
        Module of the program, which calls ``be_program``.
    arguments : sequence of str
    failure : str
        Begin of the error if the program itself fails.
    seconds : float
        Time limit [s].
    inherited : collection of int
        Descriptors of open files that the program uses, too.

    Raises
    ------
    PPaaSError
        The error of the program.
    Unavailable
        The program ran out of time, or crashed.
    """
    command = [sys.executable, "-m", module, *arguments]
    try:
        process = subprocess.run(
            command, capture_output=True, text=True, check=False, timeout=seconds, pass_fds=inherited
        )
    except subprocess.TimeoutExpired as error:
        raise Unavailable(f"{failure} within {seconds:g} s: try again later, or with a smaller map") from error
    if process.returncode:
        logger.error("%s exited with status %d: %s", module, process.returncode, process.stderr[-_MOST_LOGGED:])
        raise Unavailable(f"{failure} (exit status {process.returncode}): it may be too large for this machine")
    answer: dict[str, Any] = json.loads(process.stdout)
    if "fault" in answer:
        raise rebuild(*answer["fault"])
    return answer["result"]


def be_program(work: Callable[[], Any], too_large: PPaaSError) -> None:
    """Limit this process, do its work, and write the result or the error to standard output.

    Parameters
    ----------
    work : callable
        Returns the result, as values of JSON.
    too_large : PPaaSError
        Error if the work needs more than `MEMORY`.
    """
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    os.nice(NICE)
    sys.stdout.write(json.dumps(outcome_of(work, too_large)))


def outcome_of(work: Callable[[], Any], too_large: PPaaSError) -> dict[str, Any]:
    """Do the work of a program; return the content of its output."""
    try:
        return {"result": work()}
    except PPaaSError as error:
        fault = error
    except MemoryError:
        fault = too_large
    return {"fault": [fault.slug, str(fault)]}
