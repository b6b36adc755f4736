"""SHA-256 of what is being written, in a thread beside the writing: each takes about as long as the other."""

import hashlib
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor

AT_ONCE = 1 << 20
"""Bytes that a thread is asked to hash: to ask costs as much as some ten thousand of them."""

Block = bytes | memoryview


class HashBeside:
    """Hashes blocks; of what is short, and for the last of them, no thread is asked."""

    def __init__(self) -> None:
        self._digest = hashlib.sha256()
        self._blocks: list[Block] = []
        self._size = 0
        self._threads = ThreadPoolExecutor(1, "hash")  # has a thread from the first time on that it is asked
        self._asked: Future[None] | None = None

    def add(self, data: Block) -> None:
        """Hash a block, at the latest at the end: what is in it must not change."""
        self._blocks.append(data)
        self._size += len(data)
        if self._size >= AT_ONCE:
            self._settle()  # so that no more waits in memory than twice as much
            self._asked = self._threads.submit(self._hash, self._blocks)
            self._blocks, self._size = [], 0

    def end(self) -> str:
        """Return the hash of all blocks, in hex."""
        self._settle()
        self._hash(self._blocks)
        return self._digest.hexdigest()

    def close(self) -> None:
        """Let the thread end, whatever has come."""
        self._threads.shutdown()

    def _settle(self) -> None:
        if self._asked is not None:
            self._asked.result()

    def _hash(self, blocks: Sequence[Block]) -> None:
        for block in blocks:
            self._digest.update(block)
