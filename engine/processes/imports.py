"""Imports of a process that starts: a thousand modules, whose objects live as long as the process."""

import contextlib
import gc
from collections.abc import Iterator


@contextlib.contextmanager
def without_collection() -> Iterator[None]:
    """Import modules without garbage collection, and exempt what they have created from later ones.

    Modules create hundreds of thousands of objects and next to no garbage. To search them meanwhile takes a tenth of
    the CPU time of a start, and each later search of all objects would stop the process for tens of milliseconds.
    """
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()
