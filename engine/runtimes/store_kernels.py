"""The kernels by which stores write and read plans, for processes that keep plans while they serve others."""

PACKAGE = "ppaas.plans.kernels"


def prepare() -> None:
    """Load them, from the cache where they are compiled: done with the first plan, it would hold up all robots.

    Call it in a thread, once, before anything else calls a kernel.
    """
    from engine.runtimes import compiled, kernels  # noqa: PLC0415  # with numba, which takes a third of a second

    compiled.load_without_compiler()
    kernels.warm_package(PACKAGE)
