"""Requests whose answer comes before the request was sent as a whole."""

import contextlib
import socket
import ssl
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from ppaas.errors import MessageTooLarge, Unavailable
from robots.client.rest import RestClient
from tests.support.network.certificates import TestAuthority

TOO_LARGE = b'{"type": "message-too-large", "title": "x", "status": 413, "detail": "at most 9 bytes"}'
REFUSAL = b"HTTP/1.1 413 Content Too Large\r\nConnection: close\r\nContent-Length: %d\r\n\r\n" % len(TOO_LARGE)
OK = b"HTTP/1.1 200 OK\r\nConnection: close\r\nContent-Length: 2\r\n\r\n{}"
LARGE = 32 << 20
"""Size of a body that the buffers of two sockets do not hold [bytes]."""

Server = Callable[[socket.socket], None]


def refuses(connection: socket.socket) -> None:
    """Answer after the head, drop a part of the body, and close with the rest unread, which resets the connection."""
    connection.recv(1 << 12)
    connection.sendall(REFUSAL + TOO_LARGE)
    dropped = 0
    while dropped < 1 << 20 and (data := connection.recv(1 << 16)):
        dropped += len(data)


def resets(connection: socket.socket) -> None:
    """Answer after the head, and close at once with the body unread."""
    connection.recv(1 << 12)
    connection.sendall(REFUSAL + TOO_LARGE)


def refuses_in_pieces(connection: socket.socket) -> None:
    """Answer byte by byte and read on until the client ends, as servers do that let it read the answer."""
    connection.recv(1 << 12)
    for byte in REFUSAL + TOO_LARGE:
        connection.sendall(bytes([byte]))
    while connection.recv(1 << 16):
        pass


def takes_all(connection: socket.socket) -> None:
    """Send informational responses, read the whole body, and answer."""
    head = b""
    while b"\r\n\r\n" not in head:
        head += connection.recv(1 << 12)
    connection.sendall(b"HTTP/1.1 100 Continue\r\n\r\n")
    head, _, body = head.partition(b"\r\n\r\n")
    length = next(
        int(line.split(b":")[1]) for line in head.split(b"\r\n") if line.lower().startswith(b"content-length")
    )
    read = len(body)
    while read < length:
        read += len(connection.recv(1 << 16))
    connection.sendall(OK)


def closes(connection: socket.socket) -> None:
    """Close without an answer."""
    connection.recv(1 << 12)


@contextmanager
def serving(server: Server, tls: ssl.SSLContext | None) -> Iterator[str]:
    """Serve one connection; yield the URL."""

    def serve() -> None:
        with contextlib.suppress(OSError), listener.accept()[0] as plain:
            connection = plain if tls is None else tls.wrap_socket(plain, server_side=True)
            with connection:
                server(connection)

    with socket.create_server(("127.0.0.1", 0)) as listener:
        thread = threading.Thread(target=serve)
        thread.start()
        yield f"{'http' if tls is None else 'https'}://127.0.0.1:{listener.getsockname()[1]}"
        thread.join()


@pytest.fixture(params=["http", "https"])
def tls(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ssl.SSLContext | None:
    """Return the server's side of TLS, whose authority clients trust; None for plain HTTP."""
    if request.param == "http":
        return None
    authority = TestAuthority(tmp_path)
    monkeypatch.setenv("SSL_CERT_FILE", str(authority.file))
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(*authority.issue("server"))
    return context


@pytest.fixture
def image(tmp_path: Path) -> Path:
    """Return a large file."""
    file = tmp_path / "image.pgm"
    with file.open("wb") as output:
        output.truncate(LARGE)
    return file


@pytest.mark.parametrize("server", [refuses, refuses_in_pieces])
async def test_the_reason_of_a_refused_upload_is_reported(
    server: Server, tls: ssl.SSLContext | None, image: Path
) -> None:
    with serving(server, tls) as url, pytest.raises(MessageTooLarge, match="at most 9 bytes"):
        await RestClient(url, "t").upload_map("big", b"yaml", image)


@pytest.mark.parametrize("server", [refuses, refuses_in_pieces])
async def test_it_is_reported_of_a_body_in_memory_too(server: Server, tls: ssl.SSLContext | None) -> None:
    with serving(server, tls) as url, pytest.raises(MessageTooLarge, match="at most 9 bytes"):
        await RestClient(url, "t").put_urdf("tb1", bytes(LARGE))


async def test_it_is_reported_although_the_connection_is_reset_at_once(image: Path) -> None:
    with serving(resets, None) as url, pytest.raises(MessageTooLarge, match="at most 9 bytes"):
        await RestClient(url, "t").upload_map("big", b"yaml", image)


async def test_an_informational_response_does_not_end_an_upload(tls: ssl.SSLContext | None, image: Path) -> None:
    with serving(takes_all, tls) as url:
        assert await RestClient(url, "t").upload_map("big", b"yaml", image) == {}


async def test_a_connection_closed_without_an_answer_is_reported(tls: ssl.SSLContext | None, image: Path) -> None:
    with serving(closes, tls) as url, pytest.raises(Unavailable, match="cannot reach"):
        await RestClient(url, "t").upload_map("big", b"yaml", image)
