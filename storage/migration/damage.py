"""Reads everything in a store, and names what is damaged."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import chain
from typing import Any

from ppaas.errors import NotFound, PPaaSError
from storage.encoding import decode
from storage.migration.copying import PAGE
from storage.migration.map_records import verify_map
from storage.migration.store_records import LISTED
from storage.ports import MapStore, Store


@dataclass(slots=True)
class Readings:
    """What was read of one table or kind: the number of records, and a description of each damaged one."""

    kind: str
    records: int = 0
    damaged: list[str] = field(default_factory=list)


def read_store(store: Store) -> Iterator[Readings]:
    """Read all records and plans of a store; yield what was found, table by table.

    Raises
    ------
    Unavailable
        The store cannot be read at all.
    """
    done: dict[str, Readings] = {}
    for data, kind, place in getattr(store, "all_records", lambda: ())():
        mine = done.setdefault(place.partition("/")[0], Readings(place.partition("/")[0]))
        _attempt(mine, place, lambda data=data, kind=kind, place=place: decode(data, kind, place))  # type: ignore[misc]
    yield from done.values()
    plans = Readings("plans")
    for map_id in store.plan_maps():
        _read_plans(store, map_id, plans)
    yield plans
    if hasattr(store, "file_faults"):
        faults = list(store.file_faults())
        yield Readings("file", 1, faults)


def read_map_store(store: MapStore) -> Iterator[Readings]:
    """Read all versions of all maps to the last byte; yield what was found."""
    maps = Readings("maps")
    ids = getattr(store, "map_ids", lambda: [head.id for head in store.maps()])()
    for map_id in ids:
        _attempt(maps, map_id, lambda map_id=map_id: verify_map(store, map_id))  # type: ignore[misc]
    yield maps


def _read_plans(store: Store, map_id: str, done: Readings) -> None:
    before: tuple[float, str] | None = None
    while True:
        try:
            heads = store.plans(map_id, before=before, limit=LISTED)
        except PPaaSError as error:
            done.damaged.append(f"plans of map {map_id}: {error}")
            return
        if not heads:
            return
        for at in range(0, len(heads), PAGE):
            ids = [head.id for head in heads[at : at + PAGE]]
            try:
                read = set(store.whole_plans(ids))
            except PPaaSError:
                read = set()
            done.records += len(read)
            for name in (name for name in ids if name not in read):  # it is damaged, or was removed meanwhile
                _attempt(done, f"plans/{name}", lambda name=name: store.plan(name))  # type: ignore[misc]
        before = heads[-1].created, heads[-1].id


def _attempt(done: Readings, place: str, read: Callable[[], Any]) -> None:
    done.records += 1
    try:
        read()
    except NotFound:
        done.records -= 1  # it was removed meanwhile
    except PPaaSError as error:
        done.damaged.append(str(error) if place in str(error) else f"{place}: {error}")


def damaged_of(readings: list[Readings]) -> list[str]:
    """Return the descriptions of everything that is damaged."""
    return list(chain.from_iterable(one.damaged for one in readings))
