"""How many threads the kernels of a container use."""

import numba


def use_threads(threads: int) -> None:
    """Let the parallel kernels that the calling thread starts use so many threads.

    It holds for the calling thread alone: each thread that calls kernels says it for itself. More than the machine
    has, or more than one where kernels run serially, is cut down.
    """
    numba.set_num_threads(min(threads, vars(numba.config)["NUMBA_NUM_THREADS"]))


class KernelThreads:
    """How many threads the kernels of this container may use, which changes with its size.

    Parameters
    ----------
    count : int
        At its start.
    """

    def __init__(self, count: int) -> None:
        self.count = count

    def __call__(self) -> int:
        """Return how many, and hold the kernels to it that the calling thread starts."""
        use_threads(self.count)
        return self.count
