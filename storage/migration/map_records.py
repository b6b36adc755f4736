"""Kinds of records that a migration copies between map stores: maps with all their publications."""

from collections.abc import Iterator, Sequence
from itertools import chain
from typing import Any

import msgspec

from storage.migration.copying import PAGE, Key, RecordKind, by_pages, each
from storage.ports import MapStore
from storage.records import MapRecord, MapVersionRecord, Publication
from storage.staged_uploads import blocks


class MapLog(msgspec.Struct, frozen=True):
    """A map and its publications, oldest first. They are numbered from zero, because each store has its own numbers."""

    id: str
    owner: str
    readers: tuple[str, ...]
    description: str
    publications: tuple[MapVersionRecord, ...]


def _ids(store: MapStore) -> Iterator[list[Key]]:
    """Yield the ids of the maps one by one, because each map may be large."""
    pages = by_pages(lambda after: store.maps(after=after, limit=PAGE), "", lambda head: head.id)
    return ([head.id] for head in chain.from_iterable(pages))


def _log(store: MapStore, key: Key) -> MapLog:
    head = store.map_head(key)
    newest_first = by_pages(
        lambda before: store.versions(head.id, before=before, limit=PAGE), None, lambda version: version.number
    )
    versions = reversed(list(chain.from_iterable(newest_first)))
    publications = (msgspec.structs.replace(version, number=number) for number, version in enumerate(versions))
    return MapLog(head.id, head.owner, tuple(head.readers), head.description, tuple(publications))


def _add(source: MapStore, target: MapStore, logs: Sequence[MapLog]) -> None:
    for log in logs:
        for publication in log.publications:
            _publish(source, target, log, publication)


def _publish(source: MapStore, target: MapStore, log: MapLog, publication: MapVersionRecord) -> MapRecord:
    """Repeat a publication in the target, with the same author and time."""
    repeated = Publication(
        map=log.id,
        author=publication.author,
        created=publication.created,
        message=publication.message,
        owner=log.owner,
        readers=log.readers,
        description=log.description,
    )
    if publication.restored:
        return target.roll_back(publication.version, repeated)
    with source.open_map(log.id, publication.version) as opened, target.stage() as upload:
        for part, buffer in opened.buffers.items():
            upload.add(part, blocks(buffer))
        return target.publish(upload, repeated)


def _is_partial(log: MapLog, there: MapLog) -> bool:
    """Return whether the target has the same map without its last publications, that is an interrupted copy."""
    first = log.publications[: len(there.publications)]
    return len(there.publications) < len(log.publications) and there == msgspec.structs.replace(log, publications=first)


def _replace(source: MapStore, target: MapStore, log: MapLog, there: MapLog) -> None:
    rest = log.publications[len(there.publications) :]
    if there.owner != log.owner or there.publications + rest != log.publications:
        target.remove_map(log.id)
        rest = log.publications
    _add(source, target, [msgspec.structs.replace(log, publications=rest)])
    target.change_map(log.id, readers=log.readers, description=log.description)


def _verify(store: MapStore, keys: Sequence[Any]) -> None:
    """Open each version of the maps; the store compares the files with their hashes."""
    for key in keys:
        for version in dict.fromkeys(publication.version for publication in _log(store, key).publications):
            with store.open_map(key, version):
                pass


MAP_KINDS: tuple[RecordKind[MapStore], ...] = (
    RecordKind("maps", _ids, each(_log), _add, _replace, _is_partial, _verify),
)
"""Maps are one kind; an interrupted copy has the first publications of a map."""
