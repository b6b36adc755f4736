"""Files that may be compressed, read as they were before."""

import bz2
import gzip
import io
import lzma
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any

from ppaas.distribution import install_hint
from ppaas.errors import InvalidInput

SUFFIXES = ("zst", "zstd", "gz", "bz2", "xz", "lz4")
"""Endings of compressed files; their first bytes count, whatever the name is."""


class UncompressedFile(io.RawIOBase):
    """Binary stream of a file, decompressed by what its first bytes are. It is read forwards only.

    Parameters
    ----------
    path : Path

    Attributes
    ----------
    compressed : bool
        Whether the file is compressed.
    cut : bool
        Whether the compressed file was found to end early, or to be damaged, as far as read.

    Raises
    ------
    InvalidInput
        The file cannot be read.
    """

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.cut = False
        self._path = path
        try:
            self._file = path.open("rb")
            head = self._file.peek(6)
        except OSError as error:
            raise unreadable(path, error) from error
        opened = next((opened for magic, opened in _OPENERS.items() if head.startswith(magic)), None)
        self.compressed = opened is not None
        self._stream: Any = self._file if opened is None else opened(self._file)

    def readable(self) -> bool:
        """Return true."""
        return True

    def readinto(self, buffer: Any) -> int:
        """Read bytes, none where the file ends or its compressed content is damaged; raises as the constructor."""
        data = self._read(len(buffer))
        buffer[: len(data)] = data
        return len(data)

    def close(self) -> None:
        """Close the file."""
        super().close()
        self._file.close()

    def _read(self, size: int) -> bytes:
        if self.cut:
            return b""
        try:
            return bytes(self._stream.read1(size))
        except OSError as error:
            if error.errno is not None:
                raise unreadable(self._path, error) from error
        except (EOFError, RuntimeError, zlib.error, lzma.LZMAError):
            pass
        except Exception as error:
            if type(error).__name__ != "ZstdError":  # of a package that may not be installed
                raise
        self.cut = True
        return b""


def unreadable(path: Path, error: OSError) -> InvalidInput:
    """Return the error for a file that the system does not let us read."""
    return InvalidInput(f"cannot read {path}: {(error.strerror or str(error)).lower()}")


def _zstd(file: IO[bytes]) -> Any:
    try:
        import zstandard  # noqa: PLC0415 - of the extras bags and recording
    except ModuleNotFoundError as error:
        raise InvalidInput(f"files compressed by zstd need the extra bags: {install_hint('bags')}") from error
    return zstandard.ZstdDecompressor(max_window_size=1 << 27).stream_reader(file, read_across_frames=True)


def _lz4(file: IO[bytes]) -> Any:
    try:
        import lz4.frame  # noqa: PLC0415 - likewise
    except ModuleNotFoundError as error:
        raise InvalidInput(f"files compressed by lz4 need the extra bags: {install_hint('bags')}") from error
    return lz4.frame.LZ4FrameFile(file)


_OPENERS: dict[bytes, Callable[[IO[bytes]], Any]] = {
    b"\x28\xb5\x2f\xfd": _zstd,
    b"\x1f\x8b": lambda file: gzip.GzipFile(fileobj=file),
    b"BZh": bz2.BZ2File,
    b"\xfd7zXZ\x00": lzma.LZMAFile,
    b"\x04\x22\x4d\x18": _lz4,
}
"""First bytes of compressed files, and what decompresses them."""
