"""Streams of a hostile cloud: answers to the handshake of a board, and frames, good and bad."""

import struct
import subprocess
from types import TracebackType
from typing import Self

from hypothesis import strategies as st

from tests.support.cloud.board_scenes import CMD_VEL
from tests.support.hostile_bytes import mutations

ACCEPTED = (
    b"HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nPPaaS-Session: %b\r\nPPaaS-Session-Id: abc\r\n\r\n"
)
HEADS = (
    ACCEPTED % b"new", ACCEPTED % b"resumed", ACCEPTED % (b"x" * 400), b"HTTP/1.1 101 OK\r\n\r\n",
    b"HTTP/1.1 401 Unauthorized\r\nContent-Length: 6\r\n\r\nno one",
    b"HTTP/1.1 503 x\r\nContent-Length: -1\r\n\r\nlater",
    b"HTTP/1.1 403\r\nContent-Length: 99999999999\r\n\r\n", b"HTTP/1.1\r\n\r\n", b"\r\n\r\n", b"SSH-2.0-x\r\n", b"",
)  # fmt: skip
MESSAGES = (
    b'{"op":"publish","topic":"amcl_pose","msg":{"x":1}}', b'{"op":"status","level":"error","msg":"no"}', b"[]", b"{}",
    b'{"op":"publish"}', b'{"op":"publish","topic":["amcl_pose"]}', b'{"op":"status"}',
    b'{"op":"publish","topic":"amcl_pose"}', b'{"op":7}', b"nul", b"\xff\xfe",
)  # fmt: skip
REASONS = (
    b"\x03\xe8left", b"\x03\xf3unavailable: x", b"\x03\xf0", b"\x03", b"\x03\xf3\xff\xfe", b"\x13\x39" + b"r" * 200,
)  # fmt: skip


def frame(first: int, payload: bytes, claimed: int | None = None) -> bytes:
    """Return a frame of a WebSocket; its head may claim another size than it has."""
    size = len(payload) if claimed is None else claimed
    if size < 126:
        return struct.pack(">BB", first, size) + payload
    return struct.pack(">BBH" if size < 65536 else ">BBQ", first, 126 + (size > 65535), size) + payload


_GOOD = (*MESSAGES, *REASONS, CMD_VEL, CMD_VEL[:-1], b"z" * 299, b"z" * 301, b"z" * 600)
_PAYLOAD = st.sampled_from(_GOOD) | st.binary()
_SIZE = st.none() | st.sampled_from([0, 1, 2, 20, 125, 126, 255, 256, 257, 300, 301, 65535, 65536, 2**32 - 1, 2**63])
_FIRST = st.sampled_from([0x81, 0x82, 0x88, 0x89, 0x8A, 0x80, 0x01, 0xFF]) | st.integers(0, 255)
_FRAMES = st.lists(st.builds(frame, _FIRST, _PAYLOAD, st.none() | st.none() | _SIZE), max_size=6).map(b"".join)
_TEXTS = b"".join(frame(0x81, text) for text in MESSAGES[:2])
_SEEDS = [HEADS[0] + _TEXTS + frame(0x82, CMD_VEL) + frame(0x88, REASONS[1])]
STREAM = st.builds(bytes.__add__, st.sampled_from(HEADS[:4]) | st.sampled_from(HEADS), _FRAMES) | mutations(_SEEDS)
"""What a cloud sends on one connection."""

PIECE = st.sampled_from([1, 7, 4096])
"""Size of the pieces in which it comes [bytes]."""


class FedBoard:
    """Program of a board that is fed with streams.

    Parameters
    ----------
    command : sequence of str
        The program, which reads cases: a length (uint32), the size of pieces (uint16), and the bytes.
    answer : int
        Size of its answer to a case [bytes]; 0 for a line.
    """

    def __init__(self, command: list[str], folder: str, answer: int) -> None:
        self._program = subprocess.Popen(
            command, cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE
        )
        self._answer = answer

    def __enter__(self) -> Self:
        """Return the board."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the program."""
        self._program.kill()
        self._program.communicate()

    def feed(self, stream: bytes, piece: int) -> str:
        """Return what the program answers to a case.

        Raises
        ------
        AssertionError
            The program has ended; the text is what it printed.
        """
        program = self._program
        assert program.stdin is not None and program.stdout is not None and program.stderr is not None
        try:
            program.stdin.write(struct.pack("<IH", len(stream), piece) + stream)
            program.stdin.flush()
            answer = program.stdout.read(self._answer) if self._answer else program.stdout.readline()
        except BrokenPipeError:
            answer = b""
        assert answer, program.stderr.read().decode(errors="replace")
        return answer.decode().strip()
