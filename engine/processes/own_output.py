"""Standard output of a program that writes answers for its parent: nothing else in the process writes there."""

import os
import sys
from typing import BinaryIO


def take_standard_output() -> BinaryIO:
    """Return standard output; what the process and its children print from now on goes to standard error.

    Children do not inherit it, so its reader does not wait for their end.
    """
    own = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    return own
