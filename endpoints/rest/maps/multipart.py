"""Streaming parser of multipart forms (RFC 7578): collects text fields, passes files on to writers.

A blocking consumer in a thread takes the body while more of it arrives.
"""

import asyncio
from collections.abc import AsyncIterator, Callable, Iterable
from contextlib import AbstractContextManager, ExitStack
from functools import partial
from types import TracebackType
from typing import Protocol

from python_multipart.exceptions import FormParserError
from python_multipart.multipart import MultipartParser, parse_options_header
from starlette.concurrency import run_in_threadpool

from ppaas.errors import InvalidParameter, MalformedMessage

MAX_TEXT = 1 << 14
"""Largest size of a text field [bytes]."""


class Writer(Protocol):
    """Destination of a file."""

    def write(self, data: memoryview) -> None:
        """Append some bytes."""


class FormReader:
    """Parser of one form.

    Parameters
    ----------
    content_type : str
        Content type of the request, with the boundary.
    open_file : callable
        Called with the name of a file field; returns a context manager of its writer, which ends with the file.
    max_fields : int
        Largest number of text fields.

    Raises
    ------
    MalformedMessage
        The content type has no valid boundary.
    """

    def __init__(
        self, content_type: str, open_file: Callable[[str], AbstractContextManager[Writer]], max_fields: int
    ) -> None:
        boundary = parse_options_header(content_type)[1].get(b"boundary", b"")
        if not boundary:
            raise MalformedMessage("the form has no boundary: 'Content-Type: multipart/form-data; boundary=…'")
        self.texts: dict[str, list[str]] = {}
        self.files: set[str] = set()
        self._open_file = open_file
        self._left = max_fields
        self._header = (bytearray(), bytearray())
        self._disposition = b""
        self._text: tuple[str, bytearray] | None = None
        self._file: Writer | None = None
        self._open = ExitStack()
        self._whole = False
        self._parser = _parser(
            boundary,
            {
                "on_header_field": partial(self._header_data, 0),
                "on_header_value": partial(self._header_data, 1),
                "on_header_end": self._header_end,
                "on_headers_finished": self._headers_finished,
                "on_part_data": self._part_data,
                "on_part_end": self._part_end,
                "on_end": self._end,
            },
        )

    def __enter__(self) -> "FormReader":
        """Return the parser itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the file that is being written, if any."""
        self._open.__exit__(kind, error, trace)

    def write(self, data: bytes) -> None:
        """Parse more of the form.

        Raises
        ------
        MalformedMessage
            The data is not a valid form.
        InvalidParameter
            The form has too many fields or too long a field; or any exception of ``open_file``.
        """
        try:
            self._parser.write(data)
        except FormParserError as error:
            raise MalformedMessage(f"the form cannot be read: {error}") from error

    def end(self) -> None:
        """Raise ``MalformedMessage`` unless the form is complete."""
        if not self._whole:
            raise MalformedMessage("the form is incomplete: send it again")

    # -- called by the parser ------------------------------------------------------------------------------------------

    def _header_data(self, part: int, data: bytes, start: int, end: int) -> None:
        self._header[part].extend(data[start:end])

    def _header_end(self) -> None:
        name, value = (bytes(part) for part in self._header)
        if name.lower() == b"content-disposition":
            self._disposition = value
        self._header = (bytearray(), bytearray())

    def _headers_finished(self) -> None:
        options = parse_options_header(self._disposition)[1]
        self._disposition = b""
        name = options.get(b"name", b"").decode(errors="replace")
        if b"filename" in options:
            self.files.add(name)
            self._file = self._open.enter_context(self._open_file(name))
            return
        self._left -= 1
        if self._left < 0:
            raise InvalidParameter("the form has too many fields")
        self._text = (name, bytearray())

    def _part_data(self, data: bytes, start: int, end: int) -> None:
        if self._file is not None:
            self._file.write(memoryview(data)[start:end])
        elif self._text is not None:
            name, text = self._text
            if len(text) + end - start > MAX_TEXT:
                raise InvalidParameter(f"form field {name[:64]!r} is too long: at most {MAX_TEXT} bytes")
            text += data[start:end]

    def _part_end(self) -> None:
        if self._text is not None:
            name, text = self._text
            self.texts.setdefault(name, []).append(text.decode(errors="replace"))
        self._text = self._file = None
        self._open.close()

    def _end(self) -> None:
        self._whole = True


def _parser(boundary: bytes, callbacks: dict[str, Callable[..., None]]) -> MultipartParser:
    try:
        return MultipartParser(boundary, callbacks)  # type: ignore[arg-type]
    except FormParserError as error:
        raise MalformedMessage(f"the form cannot be read: {error}") from error


MIN_BATCH = 1 << 20
"""Bytes collected before they are handed to a thread; a handover costs as much as consuming about 10 kB."""

MAX_WAITING = 4 << 20
"""Largest number of bytes that wait while a thread consumes others."""

Take = Callable[[bytes], object]


async def consume(stream: AsyncIterator[bytes], take: Take) -> None:
    """Pass a body to a blocking function, block by block and in order, in one thread at a time.

    No thread runs any more when this function returns or raises.

    Parameters
    ----------
    stream : async iterator of bytes
        The body. It is not read while `MAX_WAITING` bytes wait for the thread.
    take : callable
        Called with each block; its exception is raised here.
    """
    consumer = _BlockConsumer(take)
    try:
        waiting: list[bytes] = []
        size = 0
        async for block in stream:
            waiting.append(block)
            size += len(block)
            if size >= MAX_WAITING or (size >= MIN_BATCH and consumer.is_idle):
                await consumer.next(waiting)
                waiting, size = [], 0
        await consumer.next(waiting)
        await consumer.end()
    finally:
        await consumer.settle()


class _BlockConsumer:
    """Runs the consuming function in a thread, one batch of blocks after the other."""

    def __init__(self, take: Take) -> None:
        self._take = take
        self._task: asyncio.Task[None] | None = None

    @property
    def is_idle(self) -> bool:
        return self._task is None or self._task.done()

    async def next(self, blocks: list[bytes]) -> None:
        """Start consuming blocks after the previous batch; raise the exception of the previous batch."""
        await self.end()
        self._task = asyncio.create_task(run_in_threadpool(_take_all, self._take, blocks))

    async def end(self) -> None:
        """Wait for the thread; raise its exception."""
        if error := await self.settle():
            raise error

    async def settle(self) -> BaseException | None:
        """Wait for the thread, which cancellation of the caller does not stop; return its exception."""
        if self._task is None:
            return None
        await asyncio.wait([self._task])
        return self._task.exception()


def _take_all(take: Take, blocks: Iterable[bytes]) -> None:
    for block in blocks:
        take(block)
