"""Thread budget of kernels. It is queried before each job, since the cores of a container or robot may change."""

from collections.abc import Callable

Threads = Callable[[], int]
"""Returns the number of threads that kernels may use now."""


def one_thread() -> int:
    """Return 1, the budget of serial kernels."""
    return 1
