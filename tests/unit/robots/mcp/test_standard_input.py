"""Lines of standard input: whole, split, too long, and at the end."""

import asyncio

from robots.mcp.standard_input import LONGEST, InputLines


def reader_of(*blocks: bytes) -> asyncio.StreamReader:
    reader = asyncio.StreamReader(LONGEST)
    for block in blocks:
        reader.feed_data(block)
    reader.feed_eof()
    return reader


async def lines_of(*blocks: bytes) -> list[str]:
    return [line async for line in InputLines(reader_of(*blocks))]


async def test_lines_come_as_they_were_sent() -> None:
    assert await lines_of(b'{"a"', b': 1}\n{"b": 2}\n', b"") == ['{"a": 1}\n', '{"b": 2}\n']


async def test_bytes_that_are_not_utf_8_are_replaced() -> None:
    assert await lines_of(b"\xc3\xa4 \xff\n") == ["ä \ufffd\n"]


async def test_the_last_line_needs_no_end() -> None:
    assert await lines_of(b"one\ntwo") == ["one\n", "two"]


async def test_lines_that_are_too_long_are_skipped_whole() -> None:
    long = b"x" * (3 * LONGEST)
    assert await lines_of(b"one\n", long, b"\ntwo\n") == ["one\n", "two\n"]
    assert await lines_of(long) == []
    assert await lines_of(long, long, b"\n", long, b"\nlast\n") == ["last\n"]


async def test_a_line_of_the_longest_length_is_read() -> None:
    [line] = await lines_of(b"x" * LONGEST + b"\n")
    assert len(line) == LONGEST + 1
