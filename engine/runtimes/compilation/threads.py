"""Number of threads of the parallel kernels of a container."""

import numba


def use_threads(threads: int) -> None:
    """Set the number of threads of the parallel kernels that the calling thread starts.

    Each thread that calls kernels must set it for itself. The number is limited to the CPUs of the machine, and to one
    where kernels run serially.
    """
    numba.set_num_threads(min(threads, vars(numba.config)["NUMBA_NUM_THREADS"]))


class KernelThreads:
    """Number of threads that the kernels of this container may use; it changes with the container's size.

    Parameters
    ----------
    count : int
        Number at the start.
    """

    def __init__(self, count: int) -> None:
        self.count = count

    def __call__(self) -> int:
        """Return the number, and set it for the kernels that the calling thread starts."""
        use_threads(self.count)
        return self.count
