"""Lists in pages: each begins behind the last record of the one before, whatever was added or removed meanwhile."""

import base64
import binascii
from collections.abc import Callable, Sequence
from typing import Annotated, Any, Generic, TypeVar

import msgspec
from fastapi import Query, Request
from pydantic import BaseModel, Field

from ppaas.errors import InvalidParameter

DEFAULT_LIMIT = 100
MAX_LIMIT = 500
MAX_CURSOR = 256
PARAMETERS = frozenset({"limit", "cursor", "token"})

T = TypeVar("T")
K = TypeVar("K")
F = TypeVar("F")

Limit = Annotated[int, Query(ge=1, le=MAX_LIMIT, description="Most items of one page")]
Cursor = Annotated[
    str | None, Query(max_length=MAX_CURSOR, description="`next` of the page before; without it, the first page")
]


class Page(BaseModel, Generic[T]):
    """A part of a list."""

    items: list[T]
    next: str | None = Field(description="`cursor` of the next page; null where this is the last", examples=[None])


class Paging:
    """Which page is asked for.

    Parameters
    ----------
    request : Request
        Must have no other parameters: a limit that is misspelled would be none.
    limit : int
        Most items of it.
    cursor : str, optional
        From the page before.
    """

    def __init__(self, request: Request, limit: Limit = DEFAULT_LIMIT, cursor: Cursor = None) -> None:
        unknown = set(request.query_params) - PARAMETERS
        if unknown:
            raise InvalidParameter(f"unknown parameter {min(unknown)[:64]!a}: a list takes limit and cursor")
        self._limit = limit
        self._cursor = cursor

    @property
    def most(self) -> int:
        """How many records to look for: one more than the page has tells whether another page follows."""
        return self._limit + 1

    def key(self, kind: type[K], first: F) -> K | F:
        """Return the key that the page begins behind; ``first`` where it is the first page.

        Raises
        ------
        InvalidParameter
            The cursor is not one of this list.
        """
        if self._cursor is None:
            return first
        try:
            padded = self._cursor.encode("ascii") + b"=" * (-len(self._cursor) % 4)
            return msgspec.json.decode(base64.b64decode(padded, b"-_", validate=True), type=kind)
        except (UnicodeEncodeError, binascii.Error, msgspec.DecodeError, UnicodeDecodeError) as error:
            raise InvalidParameter("cursor: it is none of this list; begin anew without one") from error

    def page(self, found: Sequence[Any], key: Callable[[Any], Any]) -> dict[str, Any]:
        """Return the page of the records that were found, and the cursor of the next if one follows."""
        items = list(found[: self._limit])
        return {"items": items, "next": _cursor(key(items[-1])) if len(found) > len(items) else None}


def _cursor(key: Any) -> str:
    return base64.urlsafe_b64encode(msgspec.json.encode(key)).rstrip(b"=").decode("ascii")
