"""``ppaas store``: copy what a store has to another, compare two, and sweep one."""

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager, nullcontext
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from ppaas.errors import InvalidInput

if TYPE_CHECKING:
    from storage.migration.copying import Compared, Copied, RecordKind

NAME = "store"
HELP = "copy a store to another, compare two, or sweep one"

COLUMNS = ("records", "copied", "same", "different", "missing", "beyond")
DIGITS = 12
"""Of a digest, which tell one from another; ``--json`` has all of them."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "Stores are told by URL, as those of 'ppaas up --store' or of '--map-store'. A migration that was cut off goes "
        "on when it is begun again. The status is 1 where the target lacks something, or has something else."
    )
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    migrate = verbs.add_parser("migrate", help="copy what the target lacks, then read both and compare")
    check = verbs.add_parser("check", help="read both and compare")
    for verb in (migrate, check):
        verb.add_argument("source", metavar="FROM", help="URL of a store that is there")
        verb.add_argument("target", metavar="TO", help="URL of another of the same sort")
        verb.add_argument("--json", action="store_true", help="print JSON")
    sweep = verbs.add_parser("sweep", help="remove from a Cassandra the stretches that no plan has any more")
    sweep.add_argument("store", metavar="URL", help="of the store")
    migrate.add_argument("--overwrite", action="store_true", help="what differs in the target gives way")


def run(arguments: argparse.Namespace) -> int:
    """Carry out the verb; return 0 if the target has all that the source has."""
    # So here and below: ``ppaas --help`` loads this module.
    from storage.migration.copying import compare, copy  # noqa: PLC0415

    if arguments.verb == "sweep":
        return _sweep(arguments.store)
    kinds, source, target = _open(arguments.source, arguments.target)
    rows = []
    with _closing(source), _closing(target), _progress(arguments, source) as progress:
        copied = {}
        if arguments.verb == "migrate":
            for kind in kinds:
                steps = copy(kind, source, target, overwrite=arguments.overwrite)
                copied[kind.name] = progress(f"copying {kind.name}", kind, steps)
        for kind in kinds:
            found = progress(f"comparing {kind.name}", kind, compare(kind, source, target))
            rows.append(_row(found, copied.get(kind.name)))
    _show(rows, as_json=arguments.json)
    return 0 if all(row["good"] for row in rows) else 1


def _sweep(url: str) -> int:
    from storage.urls.opening import open_store  # noqa: PLC0415

    with closing(open_store(url)) as store:
        sweep = getattr(store, "sweep_entries", None)
        if sweep is None:
            raise InvalidInput(f"{url.partition(':')[0]}: stores remove at once what no plan has any more")
        sys.stdout.write(f"{sweep()} stretches removed\n")
    return 0


def _open(source: str, target: str) -> "tuple[Sequence[RecordKind[Any]], Any, Any]":
    """Return the kinds of record that two stores have, and the stores."""
    from storage.migration.map_records import MAP_KINDS  # noqa: PLC0415
    from storage.migration.store_records import KINDS  # noqa: PLC0415
    from storage.urls.backends import MAP_STORES, STORES  # noqa: PLC0415
    from storage.urls.opening import check_exists, open_map_store, open_store  # noqa: PLC0415

    if source == target:
        raise InvalidInput("FROM and TO are the same store: name another one to copy to")
    schemes = {url.partition(":")[0] for url in (source, target)}
    if schemes <= set(STORES):
        check_exists(source)
        return KINDS, open_store(source), open_store(target)
    if schemes <= set(MAP_STORES):
        check_exists(source)
        return MAP_KINDS, open_map_store(source), open_map_store(target)
    known = f"both {', '.join(f'{name}:' for name in STORES)} or both {', '.join(f'{name}:' for name in MAP_STORES)}"
    raise InvalidInput(f"{source!r} and {target!r} do not keep the same: a migration is between {known}")


def _closing(store: Any) -> Any:
    return closing(store) if hasattr(store, "close") else nullcontext()


@contextmanager
def _progress(arguments: argparse.Namespace, source: Any) -> Iterator[Any]:
    """Lend what works through the steps of a kind, shows how far they are, and returns the last one."""
    from rich.console import Console  # noqa: PLC0415
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn  # noqa: PLC0415

    console = Console(stderr=True)
    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    with Progress(*columns, console=console, disable=arguments.json or not console.is_terminal) as shown:

        def work_through(
            what: str, kind: "RecordKind[Any]", steps: "Iterator[Copied] | Iterator[Compared]"
        ) -> "Copied | Compared | None":
            total = kind.count(source) if kind.count is not None else None
            task, last = shown.add_task(what, total=total), None
            for last in steps:
                shown.update(task, completed=last.records)
            done = last.records if last is not None else 0
            shown.update(task, completed=done, total=done)
            return last

        yield work_through


def _row(found: "Compared", copied: "Copied | None") -> dict[str, Any]:
    told = asdict(found) | {"good": found.is_good}
    return told if copied is None else told | {"copied": copied.copied}


def _show(rows: list[dict[str, Any]], *, as_json: bool) -> None:
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
