"""Lines of standard input for the MCP server: of limited length, and read without a thread.

The library reads standard input in a thread, which SIGTERM cannot interrupt, and takes lines of any length.
"""

import asyncio
import logging
import sys
from typing import Self

from ppaas.errors import InvalidInput

logger = logging.getLogger(__name__)

LONGEST = 1 << 20
"""Longest line that is read [bytes]; longer ones are skipped, and logged."""


class InputLines:
    """Asynchronous iterator over lines of UTF-8, as the transport of the library expects of a text file.

    Parameters
    ----------
    reader : StreamReader
    """

    def __init__(self, reader: asyncio.StreamReader) -> None:
        self._reader = reader

    @classmethod
    async def opened(cls) -> Self:
        """Return the lines of standard input.

        Raises
        ------
        InvalidInput
            Standard input is a file.
        """
        reader = asyncio.StreamReader(LONGEST)
        try:
            await asyncio.get_running_loop().connect_read_pipe(
                lambda: asyncio.StreamReaderProtocol(reader), sys.stdin.buffer
            )
        except (OSError, ValueError) as error:
            raise InvalidInput(f"standard input must be a pipe of an MCP client: {error}") from error
        return cls(reader)

    def __aiter__(self) -> Self:
        """Return the lines."""
        return self

    async def __anext__(self) -> str:
        """Return the next line; ``StopAsyncIteration`` at the end of the input."""
        skips = False
        while True:
            try:
                line = await self._reader.readuntil(b"\n")
            except asyncio.LimitOverrunError as error:
                skips = skips or self._note()
                await self._reader.readexactly(error.consumed)
            except asyncio.IncompleteReadError as error:
                if skips or not error.partial:
                    raise StopAsyncIteration from None
                return error.partial.decode(errors="replace")
            else:
                if not skips:
                    return line.decode(errors="replace")
                skips = False

    def _note(self) -> bool:
        logger.warning("skipped a line of more than %d bytes of standard input", LONGEST)
        return True
