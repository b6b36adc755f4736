"""Options that name the stores of a cloud: the same for a cloud, a backup of it and a restoration."""

import argparse
import os
from pathlib import Path


def add_stores(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("--data", type=Path, default=Path("var"), help="folder of the embedded stores (./%(default)s)")
    parser.add_argument("--store", help="URL of the store of everything but maps (SQLite in the data folder)")
    parser.add_argument("--map-store", help="URL of the map store (files in the data folder)")
    for option, variable in (("--store-file", "PPAAS_STORE"), ("--map-store-file", "PPAAS_MAP_STORE")):
        parser.add_argument(
            option,
            type=Path,
            metavar="FILE",
            help=f"file with that URL, to keep a password out of the arguments; or give it in the variable {variable}",
        )


def settle_stores(arguments: argparse.Namespace) -> None:
    """Take the URLs of the stores from arguments, files or the environment, with their passwords.

    Raises
    ------
    InvalidInput
        A file cannot be read.
    """
    from storage.urls.passwords import chosen_url  # noqa: PLC0415 - ``ppaas --help`` loads this module

    given = arguments
    given.store = chosen_url("--store", given.store, given.store_file, "PPAAS_STORE", os.environ)
    given.map_store = chosen_url("--map-store", given.map_store, given.map_store_file, "PPAAS_MAP_STORE", os.environ)


def store_urls(arguments: argparse.Namespace) -> tuple[str, str]:
    """Return the URLs of the store and of the map store that settled arguments name; by default in the data folder."""
    data = arguments.data.resolve()
    return arguments.store or f"sqlite:///{data / 'ppaas.sqlite'}", arguments.map_store or f"file:///{data / 'maps'}"
