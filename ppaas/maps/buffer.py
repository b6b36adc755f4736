"""Files as functions of this room take them: bytes, or what reads as they do, such as a file mapped into memory."""

from typing import Protocol


class Buffer(Protocol):
    """What is in a file."""

    def __len__(self) -> int:
        """Return how many bytes."""
        ...

    def __getitem__(self, part: slice, /) -> bytes:
        """Return some of them."""
        ...

    def __buffer__(self, flags: int, /) -> memoryview:
        """Lend all of them."""
        ...
