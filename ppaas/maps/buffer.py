"""Type of file contents that the map readers accept: bytes, or a memory-mapped file."""

from typing import Protocol


class Buffer(Protocol):
    """Content of a file."""

    def __len__(self) -> int:
        """Return the size [bytes]."""
        ...

    def __getitem__(self, part: slice, /) -> bytes:
        """Return a copy of a part."""
        ...

    def __buffer__(self, flags: int, /) -> memoryview:
        """Return a view of the whole content, without copying it."""
        ...
