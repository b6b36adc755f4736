"""Pagination by cursor: each page starts after the last record of the previous one, even if records changed since."""

import base64
import binascii
from collections.abc import Callable, Sequence
from itertools import islice
from typing import Annotated, Any, ClassVar, Generic, TypeVar

import msgspec
from fastapi import Query, Request
from pydantic import BaseModel, Field

from ppaas.decoding import from_json
from ppaas.errors import InvalidParameter
from storage.migration.copying import one_by_one

DEFAULT_LIMIT = 100
MAX_LIMIT = 500
MAX_CURSOR = 256
PARAMETERS = frozenset({"limit", "cursor", "token"})

T = TypeVar("T")
K = TypeVar("K")
F = TypeVar("F")

Limit = Annotated[int, Query(ge=1, le=MAX_LIMIT, description="Maximum number of items per page")]
Cursor = Annotated[
    str | None, Query(max_length=MAX_CURSOR, description="`next` of the previous page; omit it for the first page")
]


class Page(BaseModel, Generic[T]):
    """One page of a list."""

    items: list[T]
    next: str | None = Field(description="`cursor` of the next page; null on the last page", examples=[None])


class Paging:
    """Parameters of a page request.

    Parameters
    ----------
    request : Request
        Must have no other query parameters, so that a misspelled limit is not ignored.
    limit : int
        Maximum number of items.
    cursor : str, optional
        ``next`` of the previous page.

    Attributes
    ----------
    filters : frozenset of str
        Further query parameters of the list.
    """

    filters: ClassVar[frozenset[str]] = frozenset()

    def __init__(self, request: Request, limit: Limit = DEFAULT_LIMIT, cursor: Cursor = None) -> None:
        unknown = set(request.query_params) - PARAMETERS - self.filters
        if unknown:
            known = ", ".join(sorted({"cursor", "limit"} | self.filters))
            raise InvalidParameter(f"unknown query parameter {min(unknown)[:64]!a}; known: {known}")
        self._limit = limit
        self._cursor = cursor

    @property
    def fetch_limit(self) -> int:
        """Number of records to fetch: one more than the page has, to detect whether another page follows."""
        return self._limit + 1

    def key(self, kind: type[K], first: F) -> K | F:
        """Return the key after which the page starts; ``first`` for the first page.

        Raises
        ------
        InvalidParameter
            The cursor does not belong to this list.
        """
        if self._cursor is None:
            return first
        try:
            padded = self._cursor.encode("ascii") + b"=" * (-len(self._cursor) % 4)
            return from_json(base64.b64decode(padded, b"-_", validate=True), kind)
        except (UnicodeEncodeError, binascii.Error, msgspec.DecodeError, UnicodeDecodeError) as error:
            raise InvalidParameter("cursor does not belong to this list: start again without a cursor") from error

    def page(self, found: Sequence[Any], key: Callable[[Any], Any]) -> dict[str, Any]:
        """Return the page of the fetched records, with the cursor of the next page if there is one."""
        items = list(found[: self._limit])
        return {"items": items, "next": _cursor(key(items[-1])) if len(found) > len(items) else None}


class StatePaging(Paging):
    """Parameters of a page of a list that may be asked for records of one ``state`` only, which its route takes."""

    filters: ClassVar[frozenset[str]] = frozenset({"state"})

    def sought(self, read: Callable[[str], list[T]], seeks: Callable[[T], bool], key: Callable[[T], str]) -> list[T]:
        """Return the records of the page, and one more if another page follows; may block.

        Parameters
        ----------
        read : callable
            Takes a key, and returns the next records after it.
        seeks : callable
            Returns whether a record is in the list.
        key : callable
            Returns the key of a record.
        """
        return list(islice(filter(seeks, one_by_one(read, self.key(str, ""), key)), self.fetch_limit))


def _cursor(key: Any) -> str:
    return base64.urlsafe_b64encode(msgspec.json.encode(key)).rstrip(b"=").decode("ascii")
