"""How many threads kernels may use: asked anew for each job, since a home may be given more cores, or fewer."""

from collections.abc import Callable

Threads = Callable[[], int]
"""Returns the most threads that kernels may use now."""


def one_thread() -> int:
    """Return one."""
    return 1
