"""``ppaas restore``: restore a backup into stores of any kind."""

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from typing import Any

from endpoints.cli import backup
from endpoints.cli.store import progress, row_of, show
from endpoints.store_options import add_stores, settle_stores, store_urls

NAME = "restore"
HELP = "restore a backup into stores of any kind, and compare"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "Records that the stores lack are added; others stay, unless --overwrite is given. An interrupted restoration "
        "continues when it is started again. Stop the cloud of these stores before. The exit status is 1 if records "
        "differ or are missing afterwards."
    )
    backup.add_place(parser)
    parser.add_argument("--backup", default="latest", metavar="ID", help="id of the backup (%(default)s)")
    add_stores(parser)
    parser.add_argument("--overwrite", action="store_true", help="replace records that differ")
    parser.add_argument("--json", action="store_true", help="print JSON")


def run(arguments: argparse.Namespace) -> int:
    """Restore and compare; return 0 if the stores have all records of the backup."""
    # Imported here: ``ppaas --help`` loads this module.
    from storage.backup.files import FileReader  # noqa: PLC0415
    from storage.backup.reading import Archive, LeftOut, kinds_of, restore_epochs  # noqa: PLC0415
    from storage.backup.sources import targets  # noqa: PLC0415
    from storage.migration.copying import compare, copy  # noqa: PLC0415
    from storage.migration.map_records import MAP_KINDS  # noqa: PLC0415
    from storage.migration.store_records import KINDS  # noqa: PLC0415

    repository = backup.opened(arguments)
    settle_stores(arguments)
    archive = Archive(repository, repository.manifest(arguments.backup))
    left_out: list[LeftOut] = []
    with targets(*store_urls(arguments)) as (store, map_store), progress(shown=not arguments.json) as shown:
        kinds: list[tuple[Any, Any]] = [(kind, store) for kind in kinds_of(archive, KINDS, left_out)]
        kinds += [(kind, map_store) for kind in kinds_of(archive, MAP_KINDS, left_out)]
        copied = [
            shown(
                f"restoring {kind.name}", copy(kind, archive, target, overwrite=arguments.overwrite), kind.count(None)
            )
            for kind, target in kinds
        ]
        found = [shown(f"comparing {kind.name}", compare(kind, archive, to), kind.count(None)) for kind, to in kinds]
        if files := len(archive.manifest.files):
            reader = FileReader(repository, archive.manifest, arguments.data)
            copied.append(shown("restoring files", reader.copy(overwrite=arguments.overwrite), files))
            found.append(shown("comparing files", reader.compare(), files))
        restore_epochs(archive.manifest, store)
    rows = [row_of(*each) for each in zip(found, copied, strict=True)]
    good = all(row["good"] for row in rows)
    missing = {each.kind: each.keys for each in left_out if each.keys}
    if arguments.json:
        result = {"id": archive.manifest.id, "good": good, "kinds": rows, "left_out": missing}
        sys.stdout.write(json.dumps(result) + "\n")
    else:
        _show(rows, missing)
    return 0 if good else 1


def _show(rows: list[dict[str, Any]], missing: Mapping[str, Sequence[Any]]) -> None:
    show(rows, as_json=False)
    for kind, keys in missing.items():
        sys.stdout.write(f"left out, since what they belong to is not in the backup: {kind} {keys}\n")
