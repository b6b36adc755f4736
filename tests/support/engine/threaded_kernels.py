"""Script that calls a parallel kernel, cached on disk, from two threads at once, and prints the results.

``python -m tests.support.engine.threaded_kernels [without-tbb]``
"""

import os
import sys
import threading

from engine.runtimes.compilation import threading_layer


def main() -> None:
    if "without-tbb" in sys.argv:
        threading_layer._load_tbb = lambda: False
    layer = threading_layer.choose()

    import numpy as np

    from engine.runtimes.compilation.threading_layer import use_threads
    from tests.support.stress.kernels import relax, warm

    warm()
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})  # as in a container, after the kernels were compiled
    right = []

    def call() -> None:
        use_threads(2)
        grid = np.ones((64, 64))
        for _ in range(300):
            grid = relax(grid)
        right.append(bool(np.all(grid == 301.0)))

    callers = [threading.Thread(target=call) for _ in range(2)]
    for caller in callers:
        caller.start()
    for caller in callers:
        caller.join()

    import numba

    compiled_later = numba.njit(lambda x: x + 1)(1)
    sys.stdout.write(f"{layer} {numba.get_num_threads()} {right} {compiled_later}\n")


if __name__ == "__main__":
    main()
