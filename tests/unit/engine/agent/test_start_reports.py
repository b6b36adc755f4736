"""A machine tells its master that it is starting, until it registers."""

import asyncio
from collections.abc import AsyncIterator

import pytest

from engine.agent import master_session
from engine.agent.config import AgentConfig
from engine.agent.master_session import Master, report_start
from engine.processes.background import cancel_all
from engine.protocols import control_link
from engine.protocols.framing import FrameStream
from engine.runtimes.compilation.compile_pool import CompileReport
from engine.runtimes.compilation.kernel_compiler import KernelCompiler
from engine.specs.start_state import KernelProgress
from ppaas.errors import Unavailable
from tests.support.engine.engine_links import pair, receive
from tests.support.waiting import patience

CONFIG = AgentConfig("m1", "", "secret", "", "cloud", "memory:", "memory:")


class Cloud:
    """A master that a machine can dial, once the test lets it."""

    def __init__(self) -> None:
        self.is_up = asyncio.Event()
        self.links: asyncio.Queue[FrameStream[control_link.FromAgent]] = asyncio.Queue()

    async def dial(self) -> Master:
        if not self.is_up.is_set():
            raise Unavailable("not yet")
        near, far = await pair(control_link.ToAgent, control_link.FromAgent)
        self.links.put_nowait(far)
        return near


@pytest.fixture
async def compiler(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[KernelCompiler]:
    monkeypatch.setattr(master_session, "REPORT_PERIOD", 0.02)
    made = KernelCompiler()
    monkeypatch.setattr(made, "begin", lambda: None)
    yield made
    await made.close()


async def test_it_reports_again_and_again_how_far_its_kernels_are(compiler: KernelCompiler) -> None:
    cloud = Cloud()
    reporting = asyncio.create_task(report_start(CONFIG, compiler, cloud.dial, delay=0.0))
    await asyncio.sleep(0.05)
    cloud.is_up.set()
    link = await cloud.links.get()
    assert await receive(link) == control_link.MachineStarting("m1", "secret")
    compiler.report = CompileReport(("a.kernels.b", "a.kernels.c"), ("a.kernels.b",))
    expected = control_link.MachineStarting("m1", "secret", KernelProgress(1, 2))
    async with patience(10):
        while await receive(link) != expected:
            pass
    await link.close()
    again = await cloud.links.get()  # the master was restarted
    assert await receive(again) == expected
    await cancel_all((reporting,))
    async with patience(10):
        while await again.receive() is not None:
            pass


async def test_a_usual_start_reports_nothing(compiler: KernelCompiler) -> None:
    cloud = Cloud()
    cloud.is_up.set()
    reporting = asyncio.create_task(report_start(CONFIG, compiler, cloud.dial, delay=600.0))
    await asyncio.sleep(0)
    await cancel_all((reporting,))
    assert cloud.links.empty()
