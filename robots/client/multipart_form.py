"""Multipart forms (RFC 7578), streamed in blocks: a file is never loaded whole."""

import secrets
from collections.abc import Iterator, Sequence
from pathlib import Path

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
