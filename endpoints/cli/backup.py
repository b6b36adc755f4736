"""``ppaas backup``: back up the stores of a cloud, list and check backups, and remove old ones."""

import argparse
import itertools
import json
import signal
import sys
import time
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from endpoints.store_options import add_stores, settle_stores, store_urls
from ppaas.bounded import whole
from ppaas.clock import monotonic
from ppaas.distribution import check_versions
from ppaas.errors import InvalidInput, PPaaSError

if TYPE_CHECKING:
    from storage.backup.manifest import BackupManifest
    from storage.backup.repository import Repository

NAME = "backup"
HELP = "back up the stores of a cloud; list, check and remove backups"
DEFAULT_VERB = "create"

NICENESS = 10
"""Priority of the process: robots of the same computer come first."""

MIN_HOURS, MAX_HOURS = 0.001, 10_000.0

COLUMNS = ("id", "begun", "seconds", "maps", "plans", "robots", "size", "added", "release")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "The verb may be left out: 'ppaas backup /mnt/backups' backs up the stores of ./var while the cloud runs. "
        "PLACE is a folder, or the URL of a bucket with a prefix: s3://, gs:// or az://, with the credentials that the "
        "tools of these services take from the environment. 'ppaas restore' restores a backup, into stores of any kind."
    )
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    create = verbs.add_parser("create", help="add a backup of all stores (the default verb)")
    listing = verbs.add_parser("list", help="list the backups, oldest first")
    check = verbs.add_parser("check", help="read all blocks of a backup, and name what is damaged")
    remove = verbs.add_parser("remove", help="remove backups, and what no other backup needs")
    for verb in (create, listing, check, remove):
        add_place(verb)
        verb.add_argument("--json", action="store_true", help="print JSON")
    add_stores(create)
    create.add_argument(
        "--recordings", action="store_true", help="back up complete recordings in the data folder, too (off)"
    )
    create.add_argument(
        "--machine-keys",
        action="store_true",
        help="back up the keys by which machines and standbys know the cloud, too: encrypted, with --key-file (off)",
    )
    create.add_argument(
        "--keep", type=whole(1), metavar="NUMBER", help="remove all but the newest backups afterwards (keep all)"
    )
    create.add_argument(
        "--every", type=_hours, metavar="HOURS", help="add one now and again after these hours, until SIGTERM (once)"
    )
    check.add_argument("backup", nargs="?", default="latest", help="id of the backup (%(default)s)")
    remove.add_argument("backups", nargs="*", metavar="BACKUP", help="ids of backups")
    remove.add_argument("--keep", type=whole(1), metavar="NUMBER", help="remove all but the newest ones")


def add_place(parser: argparse.ArgumentParser) -> None:
    """Add the arguments that name a repository of backups."""
    parser.add_argument("place", metavar="PLACE", help="folder or URL of the backups")
    parser.add_argument(
        "--key-file",
        type=Path,
        metavar="FILE",
        help="file with the key that encrypts the backups; 'create' makes one with a new key if it does not exist. "
        "Keep a copy elsewhere: nothing can be restored without it (not encrypted)",
    )


def opened(arguments: argparse.Namespace, *, create: bool = False) -> "Repository":
    """Open the repository that the arguments name."""
    check_versions("backup")
    # Imported here and below: ``ppaas --help`` loads this module.
    from storage.backup.repository import Repository  # noqa: PLC0415
    from storage.backup.sealing import read_key  # noqa: PLC0415

    key = None if arguments.key_file is None else read_key(arguments.key_file, create=create)
    return Repository.at(arguments.place, key, create=create)


def run(arguments: argparse.Namespace) -> int:
    """Execute the verb; return 0 if it did what it says, and found nothing damaged."""
    match arguments.verb:
        case "create":
            return _create(arguments)
        case "list":
            _show(map(row_of, opened(arguments).manifests()), as_json=arguments.json)
            return 0
        case "check":
            return _check(arguments)
        case _:
            return _remove(arguments)


def _hours(text: str) -> float:
    hours = float(text)
    if not MIN_HOURS <= hours <= MAX_HOURS:
        raise argparse.ArgumentTypeError(f"give {MIN_HOURS:g} to {MAX_HOURS:g} hours, not {text}")
    return hours


def _create(arguments: argparse.Namespace) -> int:
    if arguments.machine_keys and arguments.key_file is None:
        raise InvalidInput("the keys of machines are backed up encrypted only: give --key-file FILE")
    settle_stores(arguments)
    urls = store_urls(arguments)
    if arguments.every is None:
        return _create_one(arguments, urls)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))  # the lock is given back
    while True:
        due = monotonic() + arguments.every * 3600
        try:
            _create_one(arguments, urls)
        except PPaaSError as error:  # the next one may succeed: a store or the place is away
            sys.stderr.write(f"ppaas: {error.slug}: {error}; the next backup is in {arguments.every:g} h\n")
        sys.stdout.flush()
        time.sleep(max(0.0, due - monotonic()))


def _create_one(arguments: argparse.Namespace, urls: tuple[str, str]) -> int:
    from endpoints.cli.store import progress  # noqa: PLC0415
    from storage.backup.sources import existing  # noqa: PLC0415
    from storage.backup.writing import BackupWriter  # noqa: PLC0415

    repository = opened(arguments, create=True)
    files = arguments.data, _files(arguments)
    with repository.locked() as lock, existing(*urls, *files) as sources:
        writer = BackupWriter(repository, sources, lock.renew)
        with progress(shown=not arguments.json) as shown:
            for kind, steps in itertools.groupby(writer.steps(), lambda step: step.kind):
                shown(f"backing up {kind}", steps)
        if arguments.keep is not None:
            repository.remove(repository.ids()[: -arguments.keep])
    _show([row_of(writer.manifest)], as_json=arguments.json)
    return 0


def _files(arguments: argparse.Namespace) -> tuple[str, ...]:
    """Return the names of the files in the data folder that are backed up."""
    from engine.remote.replica import names_in  # noqa: PLC0415
    from storage.recordings import RECORDINGS, RecordingsFolder  # noqa: PLC0415

    data: Path = arguments.data
    keys = names_in(data) if arguments.machine_keys else []
    recordings = RecordingsFolder(data / RECORDINGS).finished() if arguments.recordings else []
    return (*keys, *(path.relative_to(data).as_posix() for path in recordings))


def _check(arguments: argparse.Namespace) -> int:
    from storage.backup.reading import Archive  # noqa: PLC0415

    repository = opened(arguments)
    manifest = repository.manifest(arguments.backup)
    damaged = list(Archive(repository, manifest).verify())
    if arguments.json:
        sys.stdout.write(json.dumps({"id": manifest.id, "good": not damaged, "damaged": damaged}) + "\n")
    else:
        sys.stdout.write(f"{manifest.id}: {len(manifest.blocks())} blocks, {len(damaged)} damaged\n")
        sys.stdout.writelines(f"{text}\n" for text in damaged)
    return 1 if damaged else 0


def _remove(arguments: argparse.Namespace) -> int:
    repository = opened(arguments)
    ids = repository.ids()
    if bool(arguments.backups) == (arguments.keep is not None):
        raise InvalidInput("give the ids of backups to remove, or --keep NUMBER")
    for each in arguments.backups:
        repository.manifest(each)  # names one that does not exist
    removed = arguments.backups or ids[: -arguments.keep]
    with repository.locked():
        blocks = repository.remove(removed)
    if arguments.json:
        sys.stdout.write(json.dumps({"removed": removed, "blocks": blocks}) + "\n")
    else:
        sys.stdout.write(f"{len(removed)} backups and {blocks} blocks removed\n")
    return 0


def row_of(manifest: "BackupManifest") -> dict[str, Any]:
    """Return what lists show of a backup."""
    counts = {kind: stream.records for kind, stream in manifest.streams.items()}
    return {
        "id": manifest.id,
        "begun": datetime.fromtimestamp(manifest.begun, UTC).isoformat(timespec="seconds"),
        "seconds": round(manifest.ended - manifest.begun, 1),
        "size": manifest.size,
        "added": manifest.added,
        "release": manifest.release,
        "stores": manifest.stores,
        "at_once": manifest.at_once,
        "records": counts,
        "files": len(manifest.files),
    }


def _show(rows: Iterable[dict[str, Any]], *, as_json: bool) -> None:
    if as_json:
        sys.stdout.write(json.dumps(list(rows)) + "\n")
        return
    lines = [list(COLUMNS)]
    for row in rows:
        fields = row | {kind: row["records"].get(kind, 0) for kind in ("maps", "plans", "robots")}
        fields |= {name: f"{row[name] / 1e6:.1f} MB" for name in ("size", "added")}
        lines.append([str(fields[name]) for name in COLUMNS])
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    for line in lines:
        cells = (cell.ljust(width) for cell, width in zip(line, widths, strict=True))
        sys.stdout.write("  ".join(cells).rstrip() + "\n")
