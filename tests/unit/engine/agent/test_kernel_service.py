"""Containers wait for kernels of their machine, and it answers for those that compile some themselves."""

import pytest

from engine.agent.kernel_service import MOST_COMPILING, KernelService, nothing_to_compile
from engine.protocols import machine_link
from engine.runtimes.compilation.compile_pool import CompileReport
from engine.runtimes.compilation.kernel_compiler import KernelCompiler
from engine.specs.start_state import KernelProgress
from ppaas.clock import ManualClock
from ppaas.errors import Starting

LATTICE, JPS = "ppaas.planners.lattice.kernels.driving", "ppaas.planners.grid.kernels.jps"


@pytest.fixture
def compiler() -> KernelCompiler:
    """Return a compiler that has compiled one of two modules."""
    made = KernelCompiler()
    made.report = CompileReport((LATTICE, JPS), (JPS,), compiling=(LATTICE,))
    return made


async def test_what_is_compiled_is_not_waited_for(compiler: KernelCompiler) -> None:
    await KernelService(compiler).wait(machine_link.AwaitKernels("p1", "secret", [JPS], within=0.0))


async def test_who_waits_too_long_learns_what_is_missing_and_when_to_try_again(compiler: KernelCompiler) -> None:
    with pytest.raises(Starting, match=r"1 of 2 \(missing: lattice/driving\); compiling kernels, 1 of 2") as refused:
        await KernelService(compiler).wait(machine_link.AwaitKernels("p1", "secret", [JPS, LATTICE], within=0.0))
    assert refused.value.retry_after is not None


async def test_progress_is_known_until_all_is_compiled(compiler: KernelCompiler) -> None:
    service = KernelService(compiler)
    assert service.progress == KernelProgress(1, 2, ("lattice/driving",))
    assert not service.is_complete
    compiler.is_over = True
    assert (service.progress, service.is_complete) == (None, True)
    await service.wait(machine_link.AwaitKernels("p1", "secret", [LATTICE], within=0.0))


def test_a_machine_answers_for_a_container_for_a_limited_time() -> None:
    clock = ManualClock()
    service = KernelService(nothing_to_compile()._compiler, clock)
    with service.compiles("c1"):
        assert service.compiling() == ("c1",)
        clock.advance(MOST_COMPILING)
        assert service.compiling() == ()
    with service.compiles("c1"):
        assert service.compiling() == ("c1",)
    assert service.compiling() == ()
