"""Copies the records that a target store lacks, then reads both stores and compares them.

A migration keeps no state. It walks the source page by page and looks up each record in the target, so an interrupted
migration continues when it is started again, and a repeated one copies nothing.
"""

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from typing import Any, Generic, TypeVar

import msgspec

from ppaas.errors import NotFound

S = TypeVar("S")
R = TypeVar("R")
Key = Any
"""Key of a record: an id, or a tuple of ids."""

PAGE = 64
"""Records that are read and compared at once."""

MAX_NAMED = 10
"""Largest number of differing records of a kind that a comparison names."""


@dataclass(frozen=True, slots=True)
class StoredKind(Generic[S]):
    """A kind of record, and the functions that read and write it.

    Parameters
    ----------
    name : str
        Name of the kind in the plural, for reports.
    pages : callable
        Takes a store; yields the keys of all records of the kind, page by page.
    read : callable
        Takes a store and keys; returns the existing records by key.
    add : callable
        Takes source, target and records of the source; adds them to the target, which lacks them.
    replace : callable, optional
        Takes source, target, a record of the source and the differing record of the target; replaces the latter. None
        if stores cannot replace records of this kind.
    is_partial : callable, optional
        Takes a record of the source and the target's record; returns whether the latter is an interrupted copy.
    verify : callable, optional
        Takes a store and keys; reads all data of these records and raises the errors that the store finds.
    count : callable, optional
        Takes a store; returns the number of its records, if it is known without a walk.
    exact : bool
        Whether a differing record is an error. It is not for sums, which change while a cloud runs.
    """

    name: str
    pages: Callable[[S], Iterator[list[Key]]]
    read: Callable[[S, Sequence[Key]], dict[Key, Any]]
    add: Callable[[S, S, Sequence[Any]], object]
    replace: Callable[[S, S, Any, Any], object] | None = None
    is_partial: Callable[[Any, Any], bool] | None = None
    verify: Callable[[S, Sequence[Key]], object] | None = None
    count: Callable[[S], int] | None = None
    exact: bool = True


@dataclass(slots=True)
class Copied:
    """Progress of copying one kind: records compared, copied, and left unchanged although they differ."""

    kind: str
    records: int = 0
    copied: int = 0
    different: int = 0


@dataclass(slots=True)
class Compared:
    """Progress of the comparison of one kind.

    Parameters
    ----------
    records : int
        Number of records in the source.
    same, different, missing : int
        How many of them are equal in the target, differ there, or are missing.
    beyond : int
        Number of records that only the target has.
    digest, digest_there : str
        SHA-256 of the records of the source in the order of its walk, and of the target's records of the same keys.
    named : list of str
        Keys of up to ``MAX_NAMED`` records that differ or are missing.
    """

    kind: str
    exact: bool = True
    records: int = 0
    same: int = 0
    different: int = 0
    missing: int = 0
    beyond: int = 0
    digest: str = ""
    digest_there: str = ""
    named: list[str] = field(default_factory=list)

    @property
    def is_good(self) -> bool:
        """Return whether the target has all records of the source, and equal ones where that is required."""
        return not self.missing and (not self.different or not self.exact)


def copy(kind: StoredKind[S], source: S, target: S, *, overwrite: bool = False) -> Iterator[Copied]:
    """Copy the records that the target lacks; yield the progress at the begin and after each page.

    Parameters
    ----------
    kind : StoredKind
    source, target
        Stores of the same port.
    overwrite : bool
        Whether differing records in the target are replaced.

    Raises
    ------
    Unavailable, InvalidInput, Conflict
        Errors of the stores; records copied until then stay in the target.
    """
    done = Copied(kind.name)
    yield done
    for keys in kind.pages(source):
        ours, theirs = kind.read(source, keys), kind.read(target, keys)
        missing = [record for key, record in ours.items() if key not in theirs]
        if missing:
            kind.add(source, target, missing)
        changed = [(ours[key], theirs[key]) for key in ours if key in theirs and ours[key] != theirs[key]]
        replaced = sum(_replace(kind, source, target, *both, overwrite=overwrite) for both in changed)
        done.records += len(ours)
        done.copied += len(missing) + replaced
        done.different += len(changed) - replaced
        yield done


def _replace(kind: StoredKind[S], source: S, target: S, record: Any, there: Any, *, overwrite: bool) -> bool:
    """Replace the target's record if that is allowed; return whether it was replaced."""
    partial = kind.is_partial is not None and kind.is_partial(record, there)
    if kind.replace is None or not (overwrite or partial):
        return False
    kind.replace(source, target, record, there)
    return True


def compare(kind: StoredKind[S], source: S, target: S) -> Iterator[Compared]:
    """Read both stores and compare them; yield the progress after each page. Raises the errors of the stores."""
    done = Compared(kind.name, kind.exact)
    digests = hashlib.sha256(), hashlib.sha256()
    for keys in kind.pages(source):
        ours, theirs = kind.read(source, keys), kind.read(target, keys)
        for key, record in ours.items():
            digests[0].update(msgspec.msgpack.encode(record))
            if key in theirs:
                digests[1].update(msgspec.msgpack.encode(theirs[key]))
            _count(done, key, record, theirs)
        if kind.verify is not None:
            kind.verify(source, list(ours))
            kind.verify(target, list(theirs))
        yield done
    done.beyond = sum(map(len, kind.pages(target))) - done.same - done.different
    done.digest, done.digest_there = (digest.hexdigest() for digest in digests)
    yield done


def _count(done: Compared, key: Key, record: Any, theirs: Mapping[Key, Any]) -> None:
    done.records += 1
    if key not in theirs:
        done.missing += 1
    elif theirs[key] == record:
        done.same += 1
        return
    else:
        done.different += 1
    if len(done.named) < MAX_NAMED:
        done.named.append("/".join(map(str, key)) if isinstance(key, tuple) else str(key))


# -- building blocks of kinds ------------------------------------------------------------------------------------------


def by_pages(ask: Callable[[Any], list[R]], first: Any, key: Callable[[R], Any]) -> Iterator[list[R]]:
    """Yield a list of a store page by page.

    Parameters
    ----------
    ask : callable
        Returns the page after a key.
    first
        Key that precedes all others.
    key : callable
        Returns the key of an item.
    """
    last = first
    while page := ask(last):
        yield page
        last = key(page[-1])


def one_by_one(ask: Callable[[Any], list[R]], first: Any, key: Callable[[R], Any]) -> Iterator[R]:
    """Yield a list of a store item by item; see `by_pages`."""
    return chain.from_iterable(by_pages(ask, first, key))


def each(read: Callable[[S, Key], R]) -> Callable[[S, Sequence[Key]], dict[Key, R]]:
    """Return a function that reads several records, given one that reads one record or raises ``NotFound``."""

    def read_each(store: S, keys: Sequence[Key]) -> dict[Key, R]:
        found = {}
        for key in keys:
            try:
                found[key] = read(store, key)
            except NotFound:
                continue
        return found

    return read_each
