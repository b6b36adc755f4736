"""What a migration copies of map stores: maps, with all that was ever published of them."""

from collections.abc import Iterator, Sequence
from itertools import chain
from typing import Any

import msgspec

from storage.migration.copying import PAGE, Key, Kind, by_pages, each
from storage.ports import MapStore
from storage.records import MapRecord, MapVersionRecord, Publication
from storage.staged_uploads import blocks


class MapLog(msgspec.Struct, frozen=True):
    """A map and its publications, the oldest first, numbered as they come: each store has numbers of its own."""

    id: str
    owner: str
    readers: tuple[str, ...]
    description: str
    publications: tuple[MapVersionRecord, ...]


def _ids(store: MapStore) -> Iterator[list[Key]]:
    """Walk the maps one by one: each may be large."""
    pages = by_pages(lambda after: store.maps(after=after, limit=PAGE), "", lambda head: head.id)
    return ([head.id] for head in chain.from_iterable(pages))


def _log(store: MapStore, key: Key) -> MapLog:
    head = store.map_head(key)
    newest_first = by_pages(
        lambda before: store.versions(head.id, before=before, limit=PAGE), None, lambda version: version.number
    )
    versions = reversed(list(chain.from_iterable(newest_first)))
    publications = (msgspec.structs.replace(version, number=place) for place, version in enumerate(versions))
    return MapLog(head.id, head.owner, tuple(head.readers), head.description, tuple(publications))


def _add(source: MapStore, target: MapStore, logs: Sequence[MapLog]) -> None:
    for log in logs:
        for publication in log.publications:
            _publish(source, target, log, publication)


def _publish(source: MapStore, target: MapStore, log: MapLog, publication: MapVersionRecord) -> MapRecord:
    """Publish once more what was published, by the same author and at the same time."""
    said = Publication(
        map=log.id,
        author=publication.author,
        created=publication.created,
        message=publication.message,
        owner=log.owner,
        readers=log.readers,
        description=log.description,
    )
    if publication.restored:
        return target.roll_back(publication.version, said)
    with source.open_map(log.id, publication.version) as opened, target.drafting() as draft:
        for part, buffer in opened.buffers.items():
            draft.add(part, blocks(buffer))
        return target.publish(draft, said)


def _is_begun(log: MapLog, there: MapLog) -> bool:
    """Tell whether a map lacks but the last publications: what is said of it was said with each of them."""
    first = log.publications[: len(there.publications)]
    return len(there.publications) < len(log.publications) and there == msgspec.structs.replace(log, publications=first)


def _replace(source: MapStore, target: MapStore, log: MapLog, there: MapLog) -> None:
    rest = log.publications[len(there.publications) :]
    if there.owner != log.owner or there.publications + rest != log.publications:
        target.remove_map(log.id)
        rest = log.publications
    _add(source, target, [msgspec.structs.replace(log, publications=rest)])
    target.change_map(log.id, readers=log.readers, description=log.description)


def _prove(store: MapStore, keys: Sequence[Any]) -> None:
    """Open each version of maps: their store compares the files with what was published."""
    for key in keys:
        for version in dict.fromkeys(publication.version for publication in _log(store, key).publications):
            with store.open_map(key, version):
                pass


MAP_KINDS: tuple[Kind[MapStore], ...] = (Kind("maps", _ids, each(_log), _add, _replace, _is_begun, _prove),)
"""Maps are one kind: of one that was cut off the publications are there up to some of them."""
