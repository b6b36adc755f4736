import asyncio
import os
import signal
import stat

import pytest
import zenoh

from engine.fabric.router import RouterProcess
from engine.fabric.session import Fabric
from engine.fabric.zenoh_config import Peering, RouterCredentials, client_config
from engine.protocols.tls_identity import TlsIdentity
from engine.remote.authority import Authority
from ppaas.errors import Unavailable
from tests.support.engine.tls_cloud import joined
from tests.support.waiting import patience


@pytest.fixture
async def router(tmp_path):
    process = RouterProcess(tmp_path / "run")
    await process.start()
    yield process
    await process.close()


def try_to_open(router: RouterProcess, credentials: RouterCredentials) -> None:
    zenoh.open(client_config(router.endpoint, credentials)).close()


async def test_client_with_the_credentials_is_accepted(router):
    await asyncio.to_thread(try_to_open, router, router.credentials)


async def test_a_client_without_the_credentials_is_refused(router):
    user, password = router.credentials.user, router.credentials.password
    for wrong in (RouterCredentials(user, "wrong"), RouterCredentials("other", password), RouterCredentials("", "")):
        with pytest.raises(zenoh.ZError):
            await asyncio.to_thread(try_to_open, router, wrong)


async def test_credentials_are_readable_by_their_user_only(router, tmp_path):
    assert stat.S_IMODE((tmp_path / "run").stat().st_mode) == 0o700
    assert stat.S_IMODE((tmp_path / "run" / "credentials").stat().st_mode) == 0o600


async def test_close_leaves_no_process_and_no_files(tmp_path):
    process = RouterProcess(tmp_path / "run")
    await process.start()
    pid = process.pid
    await process.close()
    assert pid is not None
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
    assert list((tmp_path / "run").iterdir()) == []


async def test_a_killed_router_is_restarted_at_the_same_address(router):
    first = router.pid
    os.kill(first, signal.SIGKILL)
    async with patience(10):
        while router.restarts == 0:
            await asyncio.sleep(0.01)
    assert router.pid != first
    await asyncio.to_thread(try_to_open, router, router.credentials)


async def test_a_router_listens_on_tcp_if_requested(tmp_path, unused_tcp_port):
    process = RouterProcess(tmp_path / "run", tcp=f"127.0.0.1:{unused_tcp_port}")
    await process.start()
    try:
        config = client_config(f"tcp/127.0.0.1:{unused_tcp_port}", process.credentials)
        await asyncio.to_thread(lambda: zenoh.open(config).close())
    finally:
        await process.close()


async def test_routers_of_two_hosts_forward_messages_and_reconnect(tmp_path, unused_tcp_port):
    authority = Authority(tmp_path / "machines")
    shared = RouterCredentials("agent", "of the whole cloud")
    endpoint = (f"tls/127.0.0.1:{unused_tcp_port}",)
    theirs = RouterProcess(
        tmp_path / "b", peering=peering(joined(authority, tmp_path / "m2", "m2"), shared, connect=endpoint)
    )
    ours = RouterProcess(tmp_path / "a", peering=peering(authority.identity, shared, listen=endpoint))
    await theirs.start()  # the router that it dials may start later
    await ours.start()
    received = []
    near, far = [await Fabric.open(router.endpoint, shared) for router in (ours, theirs)]
    near.subscribe("ppaas/map/**", lambda key, payload: received.append((key, payload)))
    try:
        await publish_until(far, received, b"first")
        os.kill(ours.pid, signal.SIGKILL)
        await publish_until(far, received, b"again")
    finally:
        for opened in (near, far, ours, theirs):
            await opened.close()


async def test_routers_with_another_authority_or_password_are_refused(tmp_path, unused_tcp_port):
    authority, other = Authority(tmp_path / "machines"), Authority(tmp_path / "other")
    shared = RouterCredentials("agent", "of the whole cloud")
    endpoint = (f"tls/127.0.0.1:{unused_tcp_port}",)
    ours = RouterProcess(tmp_path / "a", peering=peering(authority.identity, shared, listen=endpoint))
    stranger, mistaken = joined(other, tmp_path / "m2", "m2"), joined(authority, tmp_path / "m3", "m3")
    ours_known = TlsIdentity(stranger.key, stranger.certificate, authority.identity.authority)
    wrong = RouterCredentials("agent", "another")
    routers = [
        ours,
        RouterProcess(tmp_path / "b", peering=peering(ours_known, shared, connect=endpoint)),
        RouterProcess(tmp_path / "c", peering=peering(mistaken, wrong, connect=endpoint)),
        RouterProcess(
            tmp_path / "d", peering=peering(joined(authority, tmp_path / "m4", "m4"), shared, connect=endpoint)
        ),
    ]
    for router in routers:
        await router.start()
    received = []
    fabrics = [await Fabric.open(router.endpoint, router.credentials) for router in routers]
    fabrics[0].subscribe("ppaas/map/**", lambda key, payload: received.append((key, payload)))
    try:
        for name, fabric in zip("bc", fabrics[1:3], strict=True):
            for _ in range(20):
                fabric.publish(f"ppaas/map/{name}", b"refused")
        await publish_until(fabrics[3], received, b"expected")  # by then the others would have been received too
        assert {payload for _, payload in received} == {b"expected"}
    finally:
        for opened in (*fabrics, *routers):
            await opened.close()


def peering(identity, credentials, **ends):
    return Peering(
        str(identity.key), str(identity.certificate), str(identity.authority), credentials, **ends
    )  # fmt: skip


async def publish_until(fabric: Fabric, received: list[tuple[str, bytes]], payload: bytes) -> None:
    """Publish repeatedly until it is received: publications may be lost while routers connect."""
    async with patience(15):
        while payload not in [each for _, each in received]:
            fabric.publish("ppaas/map/topic", payload)
            await asyncio.sleep(0.05)


async def test_router_that_cannot_listen_raises_unavailable(tmp_path):
    process = RouterProcess(tmp_path / "run", tcp="256.0.0.1:1")
    with pytest.raises(Unavailable, match="before it listened"):
        await process.start()
    await process.close()
