import asyncio
import os
import signal
import stat

import pytest
import zenoh

from engine.router import RouterProcess
from engine.zenoh_config import Credentials, client_config
from ppaas.errors import Unavailable


@pytest.fixture
async def router(tmp_path):
    process = RouterProcess(tmp_path / "run")
    await process.start()
    yield process
    await process.close()


def try_to_open(router: RouterProcess, credentials: Credentials) -> None:
    zenoh.open(client_config(router.endpoint, credentials)).close()


async def test_whoever_has_the_credentials_is_let_in(router):
    await asyncio.to_thread(try_to_open, router, router.credentials)


async def test_whoever_has_them_not_is_refused(router):
    user, password = router.credentials.user, router.credentials.password
    for wrong in (Credentials(user, "wrong"), Credentials("other", password), Credentials("", "")):
        with pytest.raises(zenoh.ZError):
            await asyncio.to_thread(try_to_open, router, wrong)


async def test_nobody_else_on_the_machine_can_read_the_credentials(router, tmp_path):
    assert stat.S_IMODE((tmp_path / "run").stat().st_mode) == 0o700
    assert stat.S_IMODE((tmp_path / "run" / "credentials").stat().st_mode) == 0o600


async def test_nothing_is_left_after_close(tmp_path):
    process = RouterProcess(tmp_path / "run")
    await process.start()
    pid = process.pid
    await process.close()
    assert pid is not None
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
    assert list((tmp_path / "run").iterdir()) == []


async def test_a_router_that_is_killed_is_started_again_at_the_same_place(router):
    first = router.pid
    os.kill(first, signal.SIGKILL)
    async with asyncio.timeout(10):
        while router.restarts == 0:
            await asyncio.sleep(0.01)
    assert router.pid != first
    await asyncio.to_thread(try_to_open, router, router.credentials)


async def test_a_router_listens_on_tcp_where_it_is_told_to(tmp_path, unused_tcp_port):
    process = RouterProcess(tmp_path / "run", tcp=f"127.0.0.1:{unused_tcp_port}")
    await process.start()
    try:
        config = client_config(f"tcp/127.0.0.1:{unused_tcp_port}", process.credentials)
        await asyncio.to_thread(lambda: zenoh.open(config).close())
    finally:
        await process.close()


async def test_a_router_that_cannot_listen_says_so(tmp_path):
    process = RouterProcess(tmp_path / "run", tcp="256.0.0.1:1")
    with pytest.raises(Unavailable, match="before it listened"):
        await process.start()
    await process.close()
