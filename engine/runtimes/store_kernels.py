"""The kernels by which stores write and read plans, for processes that keep plans while they serve others."""

from engine.disk_notes import alone, notes_folder

PACKAGE = "ppaas.plans.kernels"


def prepare() -> None:
    """Load them, from the cache where they are compiled: done with the first plan, it would hold up all robots.

    Call it in a thread, once, before anything else calls a kernel. Of several processes that do so on a new computer
    one compiles, and the others wait for it.
    """
    from engine.runtimes import compiled, kernels  # noqa: PLC0415  # with numba, which takes a third of a second

    compiled.load_without_compiler()
    with alone(notes_folder() / "store-kernels.lock"):
        kernels.warm_package(PACKAGE)
