"""A container that compiles a kernel itself tells its machine, before numba holds the interpreter's lock."""

import threading
from collections.abc import AsyncIterator
from pathlib import Path

import numba
import pytest
from numba.core import event

from engine.agent.container_gateway import ContainerGateway
from engine.container.kernel_gate import CompileNotice
from engine.specs.containers import Launch
from storage.memory.store import MemoryStore
from tests.support.engine.attached_container import attach_container
from tests.support.engine.fake_fabric import FakeFabric
from tests.support.engine.specs import planning_spec
from tests.support.waiting import until

COMPILES = event.Event("numba:compile", event.EventStatus.START)  # type: ignore[no-untyped-call]


@pytest.fixture
async def gateway(tmp_path: Path) -> AsyncIterator[ContainerGateway]:
    opened = ContainerGateway(tmp_path / "gate.sock", MemoryStore(), FakeFabric())
    await opened.start()
    yield opened
    await opened.close()


def notice_to(gateway: ContainerGateway, secret: str) -> CompileNotice:
    spec = planning_spec()
    return CompileNotice(Launch(spec, "", "", str(gateway.path), secret, (), 1))


def compile_beside(inside: threading.Event, go: threading.Event) -> threading.Thread:
    """Compile a kernel in a thread, which waits inside the compilation."""

    class Waits(event.Listener):
        def on_start(self, event: event.Event) -> None:
            inside.set()
            go.wait(30)

        def on_end(self, event: event.Event) -> None: ...

    def work() -> None:
        with event.install_listener("numba:compile", Waits()):  # type: ignore[no-untyped-call]
            numba.njit(lambda number: number + 1)(1)

    thread = threading.Thread(target=work)
    thread.start()
    return thread


async def test_the_machine_answers_for_a_container_while_it_compiles(gateway: ContainerGateway) -> None:
    stream = await attach_container(gateway, planning_spec())
    notice = notice_to(gateway, "secret")
    inside, go = threading.Event(), threading.Event()
    with event.install_listener("numba:compile", notice):  # type: ignore[no-untyped-call]
        thread = compile_beside(inside, go)
        await until(lambda: inside.is_set() and gateway.kernels.compiling() == (planning_spec().id,))
        go.set()
        await until(lambda: gateway.kernels.compiling() == ())
        await until(lambda: not thread.is_alive())
    await stream.close()


async def test_nobody_answers_for_a_stranger(gateway: ContainerGateway, caplog: pytest.LogCaptureFixture) -> None:
    stream = await attach_container(gateway, planning_spec())
    notice = notice_to(gateway, "wrong")
    notice.on_start(COMPILES)
    await until(lambda: "another secret" in caplog.text)
    assert gateway.kernels.compiling() == ()
    notice.on_end(COMPILES)
    await stream.close()


def test_without_its_machine_a_container_compiles_all_the_same(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    notice = CompileNotice(Launch(planning_spec(), "", "", str(tmp_path / "gone.sock"), "", (), 1))
    with event.install_listener("numba:compile", notice):  # type: ignore[no-untyped-call]
        assert numba.njit(lambda number: number + 2)(1) == 3
    assert "cannot report that a kernel is being compiled" in caplog.text
