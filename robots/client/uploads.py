"""Uploads: multipart forms, streamed in blocks, and answers that come before the request was sent as a whole.

Forms are of RFC 7578; a file is never loaded whole. A server that refuses a large body answers at once and then closes
the connection. A client that only sends would see a broken pipe, and never the reason. So it looks for an answer after
each block.
"""

import contextlib
import http.client
import io
import secrets
import socket
import ssl
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

Content = bytes | Path
"""Content of a file, or its path."""

BLOCK = 1 << 17
"""Size of the blocks that are read and sent [bytes]."""


class Form:
    """A form of fields and files.

    Parameters
    ----------
    fields : sequence of (name, value)
    files : sequence of (name, file name, content)

    Raises
    ------
    OSError
        A file cannot be read.
    """

    def __init__(self, fields: Sequence[tuple[str, str]], files: Sequence[tuple[str, str, Content]]) -> None:
        boundary = secrets.token_hex(16)
        self.content_type = f"multipart/form-data; boundary={boundary}"
        self._pieces: list[Content] = []
        parts: list[tuple[str, Content]] = [(f'name="{name}"', value.encode()) for name, value in fields]
        parts += [(f'name="{name}"; filename="{file_name}"', content) for name, file_name, content in files]
        for parameters, content in parts:
            head = f"--{boundary}\r\nContent-Disposition: form-data; {parameters}\r\n\r\n"
            self._pieces += [head.encode(), content, b"\r\n"]
        self._pieces.append(f"--{boundary}--\r\n".encode())
        self.length = sum(len(piece) if isinstance(piece, bytes) else piece.stat().st_size for piece in self._pieces)

    def __iter__(self) -> Iterator[bytes]:
        """Yield the encoded form, block by block."""
        for piece in self._pieces:
            if isinstance(piece, bytes):
                yield piece
            else:
                with piece.open("rb") as file:
                    while block := file.read(BLOCK):
                        yield block


# -- requests whose answer is read although it comes before the request was sent as a whole ----------------------------

NOTHING_YET = (BlockingIOError, ssl.SSLWantReadError, ssl.SSLWantWriteError)

INFORMAL = b"HTTP/1.1 1"
"""Beginning of an informational response, which the final one follows (RFC 9110, 15.2)."""


class _Answered(Exception):
    """The server has answered, or closed its side."""


def exchange(
    connection: http.client.HTTPConnection,
    method: str,
    path: str,
    body: bytes | Iterable[bytes],
    headers: Mapping[str, str],
) -> http.client.HTTPResponse:
    """Send a request, and stop when the answer arrives; return the response.

    Parameters
    ----------
    connection : HTTPConnection
        Connection, not open yet.
    method, path : str
    body : bytes or iterable of bytes
        Its length is in the headers.
    headers : mapping of str to str

    Raises
    ------
    OSError, HTTPException
        No answer has come.
    """
    heard = bytearray()

    def attentive() -> Iterator[bytes]:
        for block in _blocks(body):
            if not heard.startswith(INFORMAL):
                _listen(connection.sock, heard)
            yield block

    try:
        connection.request(method, path, attentive(), headers)
    except _Answered:
        pass
    except OSError:  # the server closed the connection: what it said before can still be read
        if connection.sock is None or heard:
            raise
        with contextlib.suppress(_Answered, OSError):
            _listen(connection.sock, heard)
        if not heard:
            raise
    if heard:
        connection.sock = _Reread(connection.sock, bytes(heard))
    return connection.getresponse()


def _blocks(body: bytes | Iterable[bytes]) -> Iterator[bytes]:
    if isinstance(body, bytes):
        yield from (body[at : at + BLOCK] for at in range(0, len(body), BLOCK))
    else:
        yield from body


def _listen(connected: socket.socket, heard: bytearray) -> None:
    """Append what has arrived, without waiting; raise ``_Answered`` if that is a response, or the end.

    Whether a socket is readable does not say so: with TLS, session tickets arrive too.
    """
    timeout = connected.gettimeout()
    connected.settimeout(0.0)
    try:
        heard += connected.recv(BLOCK)
    except NOTHING_YET:
        return
    finally:
        connected.settimeout(timeout)
    if not heard.startswith(INFORMAL):
        raise _Answered


class _Reread:
    """Socket of which a part was read already, as far as `http.client` uses it for a response."""

    def __init__(self, connected: socket.socket, first: bytes) -> None:
        self._socket = connected
        self._first = first

    def makefile(self, _mode: str) -> Any:
        """Return a file that begins with the part that was read."""
        return io.BufferedReader(_Joined(self._first, self._socket.makefile("rb", buffering=0)))

    def close(self) -> None:
        """Close the socket as soon as its files are closed."""
        self._socket.close()


class _Joined(io.RawIOBase):
    def __init__(self, first: bytes, then: io.RawIOBase) -> None:
        self._first = memoryview(first)
        self._then = then

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int | None:
        size = min(len(buffer), len(self._first))
        if not size:
            return self._then.readinto(buffer)
        buffer[:size] = self._first[:size]
        self._first = self._first[size:]
        return size

    def close(self) -> None:
        self._then.close()
        super().close()
