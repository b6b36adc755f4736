"""From one store to another: what the other lacks is copied, and all is read back and compared.

A migration keeps no notes. It walks the source by pages and looks for each record in the target, so one that was cut
off, wherever, goes on when it is begun again, and one that is repeated copies nothing.
"""

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

import msgspec

from ppaas.errors import NotFound

S = TypeVar("S")
R = TypeVar("R")
Key = Any
"""What a record is found by: its id, or several."""

PAGE = 64
"""Records that are looked at together."""

MOST_NAMED = 10
"""Records of a kind that are named where stores differ."""


@dataclass(frozen=True, slots=True)
class Kind(Generic[S]):
    """One kind of record, and how stores are asked for it.

    Parameters
    ----------
    name : str
        In the plural, for people.
    pages : callable
        Walks a store: the keys of all records of the kind, page by page.
    read : callable
        Returns what a store has of some keys, by key.
    add : callable
        Of a source and a target: keeps records of the one that the other does not have.
    replace : callable, optional
        Of a source and a target: keeps a record of the one in place of another, given last; None where a store cannot.
    is_begun : callable, optional
        Tells of a record and of that in the target whether that is what is left of a copy that was cut off.
    prove : callable, optional
        Reads what belongs to some keys to its last byte, and raises what the store finds wrong.
    count : callable, optional
        Returns how many a store has, where it knows without a walk.
    exact : bool
        Whether a record that differs is a fault: sums go on while a cloud runs.
    """

    name: str
    pages: Callable[[S], Iterator[list[Key]]]
    read: Callable[[S, Sequence[Key]], dict[Key, Any]]
    add: Callable[[S, S, Sequence[Any]], object]
    replace: Callable[[S, S, Any, Any], object] | None = None
    is_begun: Callable[[Any, Any], bool] | None = None
    prove: Callable[[S, Sequence[Key]], object] | None = None
    count: Callable[[S], int] | None = None
    exact: bool = True


@dataclass(slots=True)
class Copied:
    """How far the copying of one kind is: records looked at, copied, and left as they were because they differ."""

    kind: str
    records: int = 0
    copied: int = 0
    different: int = 0


@dataclass(slots=True)
class Compared:
    """How far the comparison of one kind is.

    Parameters
    ----------
    records, same, different, missing : int
        Of the source, and of these in the target.
    beyond : int
        Records that only the target has.
    digest, digest_there : str
        SHA-256 of the records of the source in the order of its walk, and of those of the same keys in the target.
    named : list of str
        Some that differ or are missing.
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
        """Tell whether the target has what it must have."""
        return not self.missing and (not self.different or not self.exact)


def copy(kind: Kind[S], source: S, target: S, *, overwrite: bool = False) -> Iterator[Copied]:
    """Copy what the target lacks; tell after each page how far it is.

    Parameters
    ----------
    kind : Kind
    source, target
        Stores of the same port.
    overwrite : bool
        Whether what differs in the target gives way.

    Raises
    ------
    Unavailable, InvalidInput, Conflict
        A store's own; what was copied until then is kept.
    """
    done = Copied(kind.name)
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


def _replace(kind: Kind[S], source: S, target: S, record: Any, there: Any, *, overwrite: bool) -> bool:
    """Keep a record in place of the one that the target has, if that may be; tell whether it may."""
    begun = kind.is_begun is not None and kind.is_begun(record, there)
    if kind.replace is None or not (overwrite or begun):
        return False
    kind.replace(source, target, record, there)
    return True


def compare(kind: Kind[S], source: S, target: S) -> Iterator[Compared]:
    """Read both stores and compare; tell after each page how far it is. Raises as the stores do."""
    done = Compared(kind.name, kind.exact)
    digests = hashlib.sha256(), hashlib.sha256()
    for keys in kind.pages(source):
        ours, theirs = kind.read(source, keys), kind.read(target, keys)
        for key, record in ours.items():
            digests[0].update(msgspec.msgpack.encode(record))
            if key in theirs:
                digests[1].update(msgspec.msgpack.encode(theirs[key]))
            _count(done, key, record, theirs)
        if kind.prove is not None:
            kind.prove(source, list(ours))
            kind.prove(target, list(theirs))
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
    if len(done.named) < MOST_NAMED:
        done.named.append("/".join(map(str, key)) if isinstance(key, tuple) else str(key))


# -- how kinds are asked for -------------------------------------------------------------------------------------------


def by_pages(ask: Callable[[Any], list[R]], first: Any, key: Callable[[R], Any]) -> Iterator[list[R]]:
    """Walk a list of a store, page by page.

    Parameters
    ----------
    ask : callable
        Returns the page behind a key.
    first
        The key before all others.
    key : callable
        Returns the key of an item.
    """
    behind = first
    while page := ask(behind):
        yield page
        behind = key(page[-1])


def each(read: Callable[[S, Key], R]) -> Callable[[S, Sequence[Key]], dict[Key, R]]:
    """Return what reads some records of a store, out of what reads one or raises ``NotFound``."""

    def read_each(store: S, keys: Sequence[Key]) -> dict[Key, R]:
        found = {}
        for key in keys:
            try:
                found[key] = read(store, key)
            except NotFound:
                continue
        return found

    return read_each
