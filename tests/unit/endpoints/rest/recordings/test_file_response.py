"""Ranges of a file (RFC 9110, section 14), and the end of its response."""

import asyncio
import tempfile
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from endpoints.rest.recordings.file_response import MOST_RANGES, OpenFileResponse, satisfiable


@pytest.mark.parametrize(
    ("value", "result"),
    [
        ("bytes=0-3", "bytes=0-3"),
        ("BYTES=0-", "bytes=0-9"),
        ("bytes=-4", "bytes=6-9"),
        ("bytes=-40", "bytes=0-9"),
        ("bytes=5-99", "bytes=5-9"),
        (f"bytes=5-{'9' * 5000}", "bytes=5-9"),
        ("bytes= 0-1 , 4-5,", "bytes=0-1,4-5"),
        ("bytes=0-1,99-", "bytes=0-1"),
        ("bytes=10-", ""),
        (f"bytes={'9' * 5000}-", ""),
        ("bytes=-0", ""),
        ("bytes=20-30,40-", ""),
        ("bytes=", None),
        ("bytes=,", None),
        ("bytes=-", None),
        ("bytes=abc", None),
        ("bytes=0-1,abc", None),
        ("bytes=5-2", None),
        ("bytes=+1-2", None),
        ("bytes=1_0-", None),
        ("bytes=\u0661-", None),
        ("bytes", None),
        ("bytes 0-3", None),
        ("items=0-3", None),
        ("", None),
        ("bytes=" + ",".join(["0-0"] * (MOST_RANGES + 1)), None),
    ],
)
def test_ranges(value: str, result: str | None) -> None:
    assert satisfiable(value, 10) == result


def test_an_empty_file_has_no_range() -> None:
    assert satisfiable("bytes=0-", 0) == satisfiable("bytes=-1", 0) == ""


@given(st.binary(max_size=40), st.text("bytes=0123456789-, ", max_size=20))
def test_whatever_is_asked_for_is_answered_and_the_file_is_closed(content: bytes, asked: str) -> None:
    status, body, closed = asyncio.run(answer(content, [(b"range", asked.encode())]))
    assert closed
    ranges = satisfiable(asked, len(content))
    assert status == (200 if ranges is None else 206 if ranges else 416)
    if status == 200:
        assert body == content


def test_a_range_of_another_state_of_the_file_is_ignored() -> None:
    headers = [(b"range", b"bytes=99-"), (b"if-range", b'"other"')]
    assert asyncio.run(answer(b"content", headers)) == (200, b"content", True)


def test_the_file_is_closed_when_the_client_is_gone() -> None:
    async def gone(_: Any) -> None:
        raise OSError("closed")

    with pytest.raises(OSError, match="closed"):
        asyncio.run(answer(b"content", [], gone))


async def answer(content: bytes, headers: list[tuple[bytes, bytes]], send: Any = None) -> tuple[int, bytes, bool]:
    """Return status, body, and whether the file is closed and what was to be released is."""
    released = []
    file = tempfile.TemporaryFile()  # noqa: SIM115 - the response closes it
    file.write(content)
    file.flush()

    async def release() -> None:
        released.append(file.closed)

    sent: list[Any] = []

    async def note(message: Any) -> None:
        sent.append(message)

    async def receive() -> Any:
        await asyncio.Event().wait()

    scope = {"type": "http", "method": "GET", "headers": headers, "asgi": {"spec_version": "2.4"}}
    response = OpenFileResponse(file, "name", "application/octet-stream", release)
    try:
        await response(scope, receive, send or note)
    finally:
        assert released == [True]
    return sent[0]["status"], b"".join(one.get("body", b"") for one in sent), file.closed
