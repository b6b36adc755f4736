"""Behaviour on real sockets: truncated, endless and invalid bodies."""

import asyncio
import json
import socket
from collections.abc import AsyncIterator

import httpx
import pytest

from endpoints.app import create_app
from endpoints.resources.services import Services
from tests.support.endpoints.problems import problem_of
from tests.support.endpoints.serving import serve
from tests.support.waiting import PATIENCE
from tests.unit.endpoints.conftest import LogIn

HUGE = 100 << 20


@pytest.fixture
async def port(services: Services) -> AsyncIterator[int]:
    async with serve(create_app(services)) as opened:
        yield opened


async def exchange(port: int, *pieces: bytes) -> bytes:
    """Send bytes and return all that is received until the server closes the connection."""
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    writer.writelines(pieces)
    answer = await reader.read()
    writer.close()
    return answer


async def test_an_upload_over_the_limit_is_refused_unread(port: int, log_in: LogIn) -> None:
    token = (await log_in("ann"))["Authorization"]
    head = (
        "POST /v1/maps HTTP/1.1\r\nHost: cloud\r\nContent-Type: multipart/form-data; boundary=b\r\n"
        f"Authorization: {token}\r\nContent-Length: {HUGE}\r\n\r\n"
    )
    # The body is not sent: only a server that refuses it by its header can respond and close.
    status, _, body = (await exchange(port, head.encode())).partition(b"\r\n\r\n")
    assert status.startswith(b"HTTP/1.1 413")
    assert b"application/problem+json" in status
    assert json.loads(body)["type"] == "urn:ppaas:problem:message-too-large"


async def test_an_endless_upload_is_aborted_soon_after_the_limit(port: int, log_in: LogIn, services: Services) -> None:
    token, loop = (await log_in("ann"))["Authorization"], asyncio.get_running_loop()
    head = (
        "POST /v1/maps HTTP/1.1\r\nHost: cloud\r\nContent-Type: multipart/form-data; boundary=b\r\n"
        f"Transfer-Encoding: chunked\r\nAuthorization: {token}\r\n\r\n"
    )
    part = b'--b\r\nContent-Disposition: form-data; name="image"; filename="x"\r\n\r\n'
    piece, sent = bytes(64 << 10), 0

    async def send() -> None:
        nonlocal sent
        await loop.sock_sendall(client, head.encode() + b"%x\r\n%s\r\n" % (len(part), part))
        while sent < HUGE:
            await loop.sock_sendall(client, b"%x\r\n%s\r\n" % (len(piece), piece))
            sent += len(piece)

    # A stream would drop the received response when sending fails.
    with socket.create_connection(("127.0.0.1", port)) as client:
        client.setblocking(False)
        sender = asyncio.create_task(send())
        answer = await loop.sock_recv(client, 4096)
        await asyncio.gather(sender, return_exceptions=True)
    assert answer.startswith(b"HTTP/1.1 413")
    assert sent < HUGE / 4
    assert services.map_store.maps() == []


async def test_a_disconnect_within_a_request_is_not_an_error(port: int, caplog: pytest.LogCaptureFixture) -> None:
    _reader, writer = await asyncio.open_connection("127.0.0.1", port)
    writer.write(
        b"POST /v1/tokens HTTP/1.1\r\nHost: cloud\r\nContent-Type: application/json\r\nContent-Length: 50\r\n\r\n{"
    )
    await writer.drain()
    writer.close()
    await writer.wait_closed()
    async with httpx.AsyncClient(base_url=f"http://127.0.0.1:{port}", timeout=PATIENCE) as client:
        problem_of(await client.get("/v1/users/me"), 401, "not-authenticated")
    assert [record for record in caplog.records if record.exc_info] == []


async def test_invalid_http_is_refused_and_the_server_keeps_serving(port: int) -> None:
    answer = await exchange(port, bytes(range(256)) * 10)
    assert answer.startswith(b"HTTP/1.1 400")
    async with httpx.AsyncClient(base_url=f"http://127.0.0.1:{port}", timeout=PATIENCE) as client:
        assert (await client.get("/openapi.json")).status_code == 200


@pytest.mark.parametrize("content", [b"\x00\xff" * 500, b"{", b"[" * 15_000, b"\xef\xbb\xbf{}", b'"x"'])
async def test_a_malformed_body_is_a_problem(port: int, content: bytes) -> None:
    async with httpx.AsyncClient(base_url=f"http://127.0.0.1:{port}", timeout=PATIENCE) as client:
        answer = await client.post("/v1/tokens", headers={"Content-Type": "application/json"}, content=content)
    assert answer.status_code in (400, 422)
    problem_of(answer, answer.status_code, answer.json()["type"].rpartition(":")[2])


async def test_login_publication_and_planning_work_over_a_real_socket(port: int, services: Services) -> None:
    await services.accounts.ensure_admin("correct horse")
    async with httpx.AsyncClient(base_url=f"http://127.0.0.1:{port}", timeout=PATIENCE) as client:
        credentials = {"user": "admin", "password": "correct horse"}
        client.headers["Authorization"] = (
            "Bearer " + (await client.post("/v1/tokens", json=credentials)).json()["token"]
        )
        yaml = b"image: a.pgm\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.2\n"
        files = {"yaml": ("a.yaml", yaml), "image": ("a.pgm", b"P5\n500 400\n255\n" + bytes(200_000))}
        assert (await client.post("/v1/maps", data={"id": "a"}, files=files)).json()["width"] == 500
        assert len((await client.get("/v1/maps/a/image")).content) == 200_015
        plan = await client.post("/v1/maps/a/plans", json={"start": [0, 0], "goal": [3, 4]})
        assert plan.json()["length"] == 5.0
