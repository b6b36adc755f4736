"""Kinds of records that a migration copies between map stores: maps with their publications and waiting reviews."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import chain
from typing import Any

import msgspec

from storage.migration.copying import PAGE, Key, StoredKind, by_pages, each
from storage.ports import MapStore
from storage.records import MapRecord, MapReview, MapVersionRecord, Publication
from storage.staged_uploads import StagedUpload, blocks
from storage.versions import ONLY_ZONES


class MapHistory(msgspec.Struct, frozen=True):
    """A map with its publications and the reviews that wait, oldest first.

    They are numbered from zero, because each store has its own numbers.
    """

    id: str
    owner: str
    readers: tuple[str, ...]
    description: str
    publications: tuple[MapVersionRecord, ...]
    reviews: tuple[MapReview, ...] = ()
    traffic: bool = False

    def versions(self) -> list[str]:
        """Return the versions that are published or wait, each once."""
        waiting = (review.version for review in self.reviews)
        return list(dict.fromkeys([*(one.version for one in self.publications), *waiting]))


def _ids(store: MapStore) -> Iterator[list[Key]]:
    """Yield the ids of the maps one by one, because each map may be large."""
    pages = by_pages(lambda after: store.maps(after=after, limit=PAGE), "", lambda head: head.id)
    return ([head.id] for head in chain.from_iterable(pages))


def _log(store: MapStore, key: Key) -> MapHistory:
    head = store.map_head(key)
    newest_first = by_pages(
        lambda before: store.versions(head.id, before=before, limit=PAGE), None, lambda version: version.number
    )
    versions = reversed(list(chain.from_iterable(newest_first)))
    publications = (msgspec.structs.replace(version, number=number) for number, version in enumerate(versions))
    listed = reversed(store.reviews(head.id))
    waiting = (review for review in listed if review.waits and review.version != head.version)
    reviews = (msgspec.structs.replace(review, number=number) for number, review in enumerate(waiting))
    readers = tuple(head.readers)
    return MapHistory(head.id, head.owner, readers, head.description, tuple(publications), tuple(reviews), head.traffic)


def _add(source: MapStore, target: MapStore, logs: Sequence[MapHistory]) -> None:
    for log in logs:
        for publication in log.publications:
            _publish(source, target, log, publication)
        for review in log.reviews:
            _propose(source, target, log, review)
        if log.traffic:
            target.change_map(log.id, traffic=True)


def _publish(source: MapStore, target: MapStore, log: MapHistory, publication: MapVersionRecord) -> MapRecord:
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
    with _uploaded(source, target, log.id, publication.version) as upload:
        return target.publish(upload, repeated)


def _propose(source: MapStore, target: MapStore, log: MapHistory, review: MapReview) -> None:
    proposal = Publication(log.id, review.author, review.created, review.message, log.owner)
    with _uploaded(source, target, log.id, review.version) as upload:
        upload.keeps = ONLY_ZONES if review.keeps_zones else frozenset()
        target.propose(upload, proposal, base=review.base, change=review.change)


@contextmanager
def _uploaded(source: MapStore, target: MapStore, map_id: str, version: str) -> Iterator[StagedUpload]:
    with source.open_map(map_id, version) as opened, target.stage() as upload:
        for part, buffer in opened.buffers.items():
            upload.add(part, blocks(buffer))
        yield upload


def _is_partial(log: MapHistory, there: MapHistory) -> bool:
    """Return whether the target has the same map without its last publications or reviews: an interrupted copy."""
    first = log.publications[: len(there.publications)]
    reviews = log.reviews[: len(there.reviews)]
    return there != log and there == msgspec.structs.replace(log, publications=first, reviews=reviews)


def _replace(source: MapStore, target: MapStore, log: MapHistory, there: MapHistory) -> None:
    rest, reviews = log.publications[len(there.publications) :], log.reviews[len(there.reviews) :]
    same = there.publications + rest == log.publications and there.reviews + reviews == log.reviews
    if there.owner != log.owner or not same:
        target.remove_map(log.id)
        rest, reviews = log.publications, log.reviews
    _add(source, target, [msgspec.structs.replace(log, publications=rest, reviews=reviews)])
    target.change_map(log.id, readers=log.readers, description=log.description, traffic=log.traffic)


def _verify(store: MapStore, keys: Sequence[Any]) -> None:
    """Open each version of the maps, published or waiting; the store compares the files with their hashes."""
    for key in keys:
        verify_map(store, key)


def verify_map(store: MapStore, map_id: str) -> None:
    """Read all versions of a map to the last byte; raises the errors that the store finds."""
    for version in _log(store, map_id).versions():
        with store.open_map(map_id, version):
            pass


MAP_KINDS: tuple[StoredKind[MapStore], ...] = (
    StoredKind("maps", _ids, each(_log), _add, _replace, _is_partial, _verify),
)
"""Maps are one kind; an interrupted copy has the first publications and reviews of a map."""
