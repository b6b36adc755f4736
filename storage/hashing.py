"""SHA-256 of data while it is written, in a second thread: hashing takes about as long as writing."""

import hashlib
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor

AT_ONCE = 1 << 20
"""Bytes that are handed to the thread at once; the handover costs as much as hashing ten thousand bytes."""

Block = bytes | memoryview


class BackgroundHash:
    """Hashes blocks in a background thread; short data and the last blocks are hashed by the caller."""

    def __init__(self) -> None:
        self._digest = hashlib.sha256()
        self._blocks: list[Block] = []
        self._size = 0
        self._threads = ThreadPoolExecutor(1, "hash")  # starts its thread with the first submit
        self._hashing: Future[None] | None = None

    def add(self, data: Block) -> None:
        """Add a block, which must not change before ``end``: it may be hashed as late as that."""
        self._blocks.append(data)
        self._size += len(data)
        if self._size >= AT_ONCE:
            self._wait_for_thread()  # at most twice `AT_ONCE` waits in memory
            self._hashing = self._threads.submit(self._hash, self._blocks)
            self._blocks, self._size = [], 0

    def end(self) -> str:
        """Return the SHA-256 of all blocks, in hex."""
        self._wait_for_thread()
        self._hash(self._blocks)
        return self._digest.hexdigest()

    def close(self) -> None:
        """Stop the thread."""
        self._threads.shutdown()

    def _wait_for_thread(self) -> None:
        if self._hashing is not None:
            self._hashing.result()

    def _hash(self, blocks: Sequence[Block]) -> None:
        for block in blocks:
            self._digest.update(block)
