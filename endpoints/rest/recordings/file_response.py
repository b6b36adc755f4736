"""Response with an open file, which is closed whatever the answer becomes, and its ranges (RFC 9110, section 14)."""

import os
import re
from collections.abc import Awaitable, Callable
from typing import BinaryIO

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import FileResponse
from starlette.types import Receive, Scope, Send

from endpoints.http.problems import problem

MOST_RANGES = 100
"""Ranges of one request; a request for more of them is answered with the whole file."""

_NOT_SATISFIABLE = 416
_BYTES = re.compile(r"(?i:bytes)=(.*)", re.ASCII)
_RANGE = re.compile(r"(\d*)-(\d*)", re.ASCII)
_MOST_DIGITS = 18

Release = Callable[[], Awaitable[None]]


class OpenFileResponse(FileResponse):
    """Response with the content of an open file, which may have no name any more.

    Parameters
    ----------
    file : BinaryIO
        The file; closed when the response has been sent or given up, and at the latest with this object.
    filename : str
        Name for the client.
    media_type : str
    release : callable, optional
        Called after that.
    """

    def __init__(self, file: BinaryIO, filename: str, media_type: str, release: Release | None = None) -> None:
        path, found = f"/proc/self/fd/{file.fileno()}", os.fstat(file.fileno())
        headers = {"X-Content-Type-Options": "nosniff"}
        super().__init__(path, media_type=media_type, filename=filename, headers=headers, stat_result=found)
        self._file = file
        self._size = found.st_size
        self._release = release

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Send the response, or the problem of a range that the file does not have."""
        try:
            await self._send_ranges(scope, receive, send)
        finally:
            self._file.close()
            if self._release is not None:
                await self._release()

    async def _send_ranges(self, scope: Scope, receive: Receive, send: Send) -> None:
        asked = Headers(scope=scope)
        condition = asked.get("if-range")
        is_current = condition is None or condition in (self.headers["etag"], self.headers["last-modified"])
        ranges = satisfiable(asked["range"], self._size) if "range" in asked and is_current else None
        if ranges == "":
            end = {"Content-Range": f"bytes */{self._size}"}
            told = f"the file has {self._size} bytes: ask for a range within it"
            answer = problem(_NOT_SATISFIABLE, "range-not-satisfiable", "Range not satisfiable", told, end)
            await answer(scope, receive, send)
            return
        understood = {**scope, "headers": list(scope["headers"])}
        headers = MutableHeaders(scope=understood)
        del headers["range"]
        if ranges is not None:
            headers["range"] = ranges
        await super().__call__(understood, receive, send)


def satisfiable(value: str, size: int) -> str | None:
    """Return a Range header with the ranges of another one that a file has.

    Parameters
    ----------
    value : str
        Value of the header.
    size : int
        Size of the file [bytes].

    Returns
    -------
    str or None
        The header; empty if the file has none of the ranges. None if the header is to be ignored: its unit is unknown,
        it cannot be read, or it has more than ``MOST_RANGES`` ranges.
    """
    match = _BYTES.fullmatch(value.strip())
    parts = [part.strip() for part in match[1].split(",")] if match else []
    ranges = [_RANGE.fullmatch(part) for part in parts if part]
    if not ranges or len(ranges) > MOST_RANGES:
        return None
    kept: list[str] = []
    for one in ranges:
        if one is None or one[0] == "-":
            return None
        first, last = (None if not text else _position(text) for text in one.groups())
        if first is not None and last is not None and last < first:
            return None
        if first is not None and first < size:
            kept.append(f"{first}-{min(size - 1 if last is None else last, size - 1)}")
        elif first is None and last and size:
            kept.append(f"{max(size - last, 0)}-{size - 1}")
    return f"bytes={','.join(kept)}" if kept else ""


def _position(digits: str) -> int:
    """Return a position in a file; a very large one is behind every end."""
    significant = digits.lstrip("0") or "0"
    return int(significant) if len(significant) <= _MOST_DIGITS else 10**_MOST_DIGITS
