"""Routes of the history of people: how many were seen, by hour and zone."""

from collections.abc import Iterator
from contextlib import suppress
from itertools import islice, takewhile
from typing import Annotated, ClassVar

from fastapi import APIRouter, Depends, Query, Request
from starlette.concurrency import run_in_threadpool

from endpoints.people.counting import collect_counts
from endpoints.people.retention import oldest_hour
from endpoints.people.settings import forget_counts
from endpoints.resources.services import Services
from endpoints.rest.dependencies import Caller, Provided, readable_head
from endpoints.rest.names import MapId
from endpoints.rest.openapi import KNOWN, problems
from endpoints.rest.paging import DEFAULT_LIMIT, Cursor, Limit, Page, Paging
from endpoints.rest.people.schemas import CountAnswer
from ppaas.clock import epoch
from ppaas.errors import Unavailable
from storage.migration.copying import one_by_one
from storage.people import BEFORE_ALL, HOUR, LAST_HOUR, PeopleCount
from storage.ports import Store

router = APIRouter(prefix="/maps/{map_id}/people/history", tags=["people"])

READ_AT_ONCE = 512
"""Counts that are read from the store at once."""

_Time = Annotated[float, Query(ge=0.0, le=LAST_HOUR, allow_inf_nan=False)]


class HistoryPaging(Paging):
    """Parameters of a page of counts: as for every list, and the counts that are sought.

    Parameters
    ----------
    request, limit, cursor
        As in every list.
    since, until : float
        Times [s since the epoch]; only hours that overlap them.
    zone : str, optional
        Only this zone; empty for the whole map.
    """

    filters: ClassVar[frozenset[str]] = frozenset({"since", "until", "zone"})

    def __init__(  # noqa: PLR0917  # FastAPI passes them by name
        self,
        request: Request,
        limit: Limit = DEFAULT_LIMIT,
        cursor: Cursor = None,
        since: Annotated[_Time, Query(description="Only hours that end after this time [s since the epoch]")] = 0.0,
        until: Annotated[
            _Time, Query(description="Only hours that begin before this time [s since the epoch]")
        ] = LAST_HOUR,
        zone: Annotated[str | None, Query(max_length=64, description="Only this zone; empty for the whole map")] = None,
    ) -> None:
        super().__init__(request, limit, cursor)
        self.since, self.until, self.zone = since, until, zone

    def seeks(self, row: PeopleCount) -> bool:
        """Return whether a count is in the list."""
        return row.hour + HOUR > self.since and self.zone in (None, row.zone)


@router.get("", response_model=Page[CountAnswer], responses=KNOWN | problems(404))
async def list_people_counts(
    map_id: MapId, services: Provided, user: Caller, paging: Annotated[HistoryPaging, Depends()]
) -> dict[str, object]:
    """List how many different people the caller's robots saw on a map, by hour and zone.

    The list has the current hour so far. It is empty unless `history` is or was on in the settings.
    """
    await readable_head(services, user, map_id)
    after = paging.key(tuple[int, str], BEFORE_ALL)
    await _collect(services, user.id, map_id)
    rows = await run_in_threadpool(_rows, services.store, (user.id, map_id), after, paging)
    return paging.page(rows, lambda row: (row.hour, row.zone))


@router.delete("", status_code=204, responses=KNOWN | problems(404))
async def remove_people_counts(map_id: MapId, services: Provided, user: Caller) -> None:
    """Remove all counts of the caller's robots on a map, also of the current hour."""
    await readable_head(services, user, map_id)
    await forget_counts(services, user.id, map_id)


async def _collect(services: Services, user: str, map_id: str) -> None:
    """Store the current counts, if the group has a coordinator that answers; otherwise only stored ones are listed."""
    with suppress(Unavailable):
        await collect_counts(services, user, map_id, epoch(), since=epoch() - HOUR)


def _rows(store: Store, key: tuple[str, str], after: tuple[int, str], paging: HistoryPaging) -> list[PeopleCount]:
    """Return the counts of a page, and one more if there is one; blocks. Expired counts are left out."""
    oldest = max(oldest_hour(store.map_people(*key).settings, epoch()), int(paging.since) - HOUR)
    sought = (row for row in _read(store, key, max(after, (oldest - 1, ""))) if paging.seeks(row))
    recent = takewhile(lambda row: row.hour < paging.until, sought)
    return list(islice(recent, paging.fetch_limit))


def _read(store: Store, key: tuple[str, str], after: tuple[int, str]) -> Iterator[PeopleCount]:
    return one_by_one(
        lambda last: store.people_counts(*key, after=last, limit=READ_AT_ONCE), after, lambda row: (row.hour, row.zone)
    )
