"""Garbage collection while a process starts: most of what it creates then lives as long as the process."""

import contextlib
import gc
from collections.abc import Iterator

YOUNG_OBJECTS = 5000
"""Number of new objects after which a started process looks for garbage among them.

Some sixty requests at once hold more objects than the 700 of Python: each search would find all of them in use.
"""


@contextlib.contextmanager
def without_collection() -> Iterator[None]:
    """Import modules and compose parts without garbage collection, and exempt what this has created from later ones.

    Modules and applications create hundreds of thousands of objects and next to no garbage. To search them meanwhile
    takes a tenth of the CPU time of a start, and each later search of all objects would stop the process for tens of
    milliseconds.
    """
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.set_threshold(YOUNG_OBJECTS, *gc.get_threshold()[1:])
        gc.enable()
