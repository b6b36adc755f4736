"""Rows of plans with their checksum: a damaged row spoils no other, and is named by its number."""

import logging
import sqlite3
import zlib
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from ppaas.errors import Unavailable
from ppaas.plans.encoding.body import PlanBody, read_bodies, read_body
from storage.store_errors import damaged, of_another_release

logger = logging.getLogger(__name__)

COLUMNS = "sequence, crc, record, body, recipe"
"""Columns of a `PlanRow`, of ``plans`` joined with ``contexts``."""


class PlanRow(NamedTuple):
    """Row of a plan.

    Parameters
    ----------
    sequence : int
    crc : int, optional
        `checksum` of the rest; None in rows of earlier releases.
    context, body, recipe : bytes
    """

    sequence: int
    crc: int | None
    context: bytes
    body: bytes
    recipe: bytes

    @property
    def is_intact(self) -> bool:
        """Whether it has its checksum, or none."""
        return self.crc is None or self.crc == checksum(self.context, self.body, self.recipe)

    def check(self) -> None:
        """Raise ``Unavailable`` if the row is damaged, or if another release wrote it in another format."""
        if not self.is_intact:
            raise damaged(self.place, "its checksum differs")
        try:
            read_body(self.body)
        except Unavailable as error:
            if self.crc is not None:
                raise of_another_release(self.place, "", error) from error
            raise damaged(self.place, error) from error

    @property
    def place(self) -> str:
        """Table and key."""
        return f"plans/{self.sequence}"


def checksum(context: bytes, body: bytes, recipe: bytes) -> int:
    """Return the CRC-32 of the parts of a plan that only it and its context have; each segment has a checksum, too."""
    return zlib.crc32(recipe, zlib.crc32(body, zlib.crc32(context)))


def readable(rows: Sequence[PlanRow]) -> list[tuple[PlanRow, PlanBody]]:
    """Return the rows that can be read, with their decoded bodies; the others are logged."""
    intact = list(_intact(rows))
    try:
        return list(zip(intact, read_bodies([row.body for row in intact]), strict=True))
    except Unavailable:
        return [(row, read_body(row.body)) for row in intact if _is_readable(row)]


def readable_rows(rows: Sequence[PlanRow]) -> list[PlanRow]:
    """Return the rows that can be read; the others are logged."""
    return [row for row, _ in readable(rows)]


def plan_faults(connection: sqlite3.Connection) -> Iterator[str]:
    """Yield the rows that cannot be read."""
    query = f"SELECT {COLUMNS} FROM plans JOIN contexts ON contexts.id = context ORDER BY sequence"
    for row in map(PlanRow._make, connection.execute(query)):
        try:
            row.check()
        except Unavailable as error:
            yield str(error)


def _intact(rows: Sequence[PlanRow]) -> Iterator[PlanRow]:
    for row in rows:
        if row.is_intact:
            yield row
        else:
            logger.error("a plan is left out: %s", damaged(row.place, "its checksum differs"))


def _is_readable(row: PlanRow) -> bool:
    try:
        row.check()
    except Unavailable as error:
        logger.error("a plan is left out: %s", error)
        return False
    return True
