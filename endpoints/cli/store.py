"""``ppaas store``: copy a store to another, compare two stores, and clean up a store."""

import argparse
import json
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager, nullcontext
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from ppaas.errors import InvalidInput

if TYPE_CHECKING:
    from storage.migration.copying import Compared, Copied, StoredKind


class Counted(Protocol):
    """A step, with the number of records so far."""

    records: int


S = TypeVar("S", bound=Counted)

NAME = "store"
HELP = "copy a store to another, compare two stores, or clean up a store"

COLUMNS = ("records", "copied", "same", "different", "missing", "beyond")
DIGITS = 12
"""Number of digits of a digest in the table; ``--json`` prints all."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "Stores are given by URL, as for 'ppaas up --store' and '--map-store'. An interrupted migration continues when "
        "it is started again. The exit status is 1 if records are missing or different in the target."
    )
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    migrate = verbs.add_parser("migrate", help="copy records that the target lacks, then compare both")
    check = verbs.add_parser("check", help="compare two stores, or read one to the end and name what is damaged")
    for verb in (migrate, check):
        verb.add_argument("source", metavar="FROM", help="URL of an existing store")
        alone = {"nargs": "?"} if verb is check else {}
        verb.add_argument("target", metavar="TO", help="URL of another store of the same kind", **alone)  # type: ignore[arg-type]
    sweep = verbs.add_parser("sweep", help="remove segments from Cassandra that no plan uses any more")
    sweep.add_argument("store", metavar="URL", help="URL of the store")
    for verb in (migrate, check, sweep):
        verb.add_argument("--json", action="store_true", help="print JSON")
    migrate.add_argument("--overwrite", action="store_true", help="replace records that differ in the target")


def run(arguments: argparse.Namespace) -> int:
    """Execute the verb; return 0 if the target has all records of the source."""
    # Imported here and below: ``ppaas --help`` loads this module.
    from storage.migration.copying import compare, copy  # noqa: PLC0415
    from storage.urls.passwords import warn_if_visible  # noqa: PLC0415

    if arguments.verb == "sweep":
        warn_if_visible(arguments.store, "URL")
        return _sweep(arguments.store, as_json=arguments.json)
    if arguments.target is None:
        warn_if_visible(arguments.source, "URL")
        return _read(arguments.source, as_json=arguments.json)
    for name, url in (("FROM", arguments.source), ("TO", arguments.target)):
        warn_if_visible(url, name)
    rows = []
    with (
        _opened(arguments.source, arguments.target, create=arguments.verb == "migrate") as (kinds, source, target),
        progress(shown=not arguments.json) as shown,
    ):
        copied = {}
        if arguments.verb == "migrate":
            for kind in kinds:
                steps = copy(kind, source, target, overwrite=arguments.overwrite)
                copied[kind.name] = shown(f"copying {kind.name}", steps, _count(kind, source))
        for kind in kinds:
            found = shown(f"comparing {kind.name}", compare(kind, source, target), _count(kind, source))
            rows.append(row_of(found, copied.get(kind.name)))
    show(rows, as_json=arguments.json)
    return 0 if all(row["good"] for row in rows) else 1


def _read(url: str, *, as_json: bool) -> int:
    """Read everything in a store and show what is damaged; return 0 if nothing is."""
    from storage.migration.damage import damaged_of, read_map_store, read_store  # noqa: PLC0415
    from storage.urls.opening import open_existing_map_store, open_existing_store  # noqa: PLC0415
    from storage.urls.registry import STORES, scheme_of  # noqa: PLC0415

    if scheme_of(url) in STORES:
        store: Any = open_existing_store(url)
        with _closing(store):
            found = list(read_store(store))
    else:
        maps = open_existing_map_store(url)
        with _closing(maps):
            found = list(read_map_store(maps))
    damaged = damaged_of(found)
    if as_json:
        kinds = [asdict(one) for one in found]
        sys.stdout.write(json.dumps({"good": not damaged, "kinds": kinds}) + "\n")
    else:
        sys.stdout.writelines(f"{one.kind.ljust(11)}  {one.records:>9}  {len(one.damaged)} damaged\n" for one in found)
        sys.stdout.writelines(f"{text}\n" for text in damaged)
    return 1 if damaged else 0


def _sweep(url: str, *, as_json: bool) -> int:
    from storage.urls.opening import open_existing_store  # noqa: PLC0415

    with closing(open_existing_store(url)) as store:
        sweep = getattr(store, "sweep_entries", None)
        if sweep is None:
            raise InvalidInput(f"{url.partition(':')[0]}: stores need no sweep: they remove unused segments at once")
        removed = sweep()
    sys.stdout.write((json.dumps({"removed": removed}) if as_json else f"{removed} segments removed") + "\n")
    return 0


@contextmanager
def _opened(source: str, target: str, *, create: bool) -> "Iterator[tuple[Sequence[StoredKind[Any]], Any, Any]]":
    """Yield the kinds of records of two stores, and the stores; only the target of a migration may be created."""
    from storage.migration.map_records import MAP_KINDS  # noqa: PLC0415
    from storage.migration.store_records import KINDS  # noqa: PLC0415
    from storage.urls.opening import (  # noqa: PLC0415
        is_same,
        open_existing_map_store,
        open_existing_store,
        open_map_store,
        open_store,
    )
    from storage.urls.registry import MAP_STORES, STORES, scheme_of, schemes  # noqa: PLC0415

    given = [scheme_of(url) for url in (source, target)]
    if is_same(source, target) and len(set(given)) == 1:
        raise InvalidInput("FROM and TO are the same store, or one is in the other: give two different stores")
    if all(scheme in STORES for scheme in given):
        kinds: Sequence[StoredKind[Any]] = KINDS
        openings: tuple[Callable[[str], Any], ...] = (
            open_existing_store,
            open_store if create else open_existing_store,
        )
    elif all(scheme in MAP_STORES for scheme in given):
        kinds, openings = MAP_KINDS, (open_existing_map_store, open_map_store if create else open_existing_map_store)
    else:
        words = " and ".join(f"{scheme}:" for scheme in given)  # without passwords
        known = f"both {schemes(STORES)} or both {schemes(MAP_STORES)}"
        raise InvalidInput(f"stores {words} do not store the same kind of data: give {known}")
    with _closing(openings[0](source)) as first, _closing(openings[1](target)) as second:
        yield kinds, first, second


def _closing(store: Any) -> Any:
    return closing(store) if hasattr(store, "close") else nullcontext(store)


def _count(kind: "StoredKind[Any]", source: Any) -> int | None:
    return kind.count(source) if kind.count is not None else None


class Steps(Protocol):
    """Runs the steps of a kind of records, shows their progress, and returns the last step."""

    def __call__(self, title: str, steps: Iterator[S], total: int | None = None) -> S:
        """Run the steps; ``total`` is the number of records, if it is known."""
        ...


@contextmanager
def progress(*, shown: bool) -> Iterator[Steps]:
    """Show the progress of steps with a number of ``records`` on a terminal until the end of the block."""
    from rich.console import Console  # noqa: PLC0415
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn  # noqa: PLC0415

    console = Console(stderr=True)
    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    with Progress(*columns, console=console, disable=not (shown and console.is_terminal)) as bars:

        def run_steps(title: str, steps: Iterator[S], total: int | None = None) -> S:
            task = bars.add_task(title, total=total)
            for last in steps:
                bars.update(task, completed=last.records)
            bars.update(task, completed=last.records, total=last.records)
            return last

        yield run_steps


def row_of(found: "Compared", copied: "Copied | None") -> dict[str, Any]:
    """Return what a table shows of a kind of records."""
    fields = asdict(found) | {"good": found.is_good}
    return fields if copied is None else fields | {"copied": copied.copied}


def show(rows: list[dict[str, Any]], *, as_json: bool) -> None:
    """Print a table of comparisons, or JSON."""
    if as_json:
        sys.stdout.write(json.dumps({"good": all(row["good"] for row in rows), "kinds": rows}) + "\n")
        return
    columns = [name for name in COLUMNS if name in rows[0]]
    widths = [max(len(name), 9) for name in columns]
    lines = [["kind", *columns, "digest"]]
    lines += [[row["kind"], *(str(row[name]) for name in columns), row["digest"][:DIGITS]] for row in rows]
    for first, *numbers, last in lines:
        cells = [number.rjust(width) for number, width in zip(numbers, widths, strict=True)]
        sys.stdout.write("  ".join([first.ljust(11), *cells, last]) + "\n")
    for row in rows:
        named = [] if row["good"] else row["named"]
        sys.stdout.writelines(f"differs or is missing: {row['kind']} {name}\n" for name in named)
