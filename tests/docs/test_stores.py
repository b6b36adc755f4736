"""Commands of stores.md work, and its stores are those of the code."""

import os
import re
import subprocess
import sys
from pathlib import Path

from endpoints.processes import server
from storage.urls.opening import open_map_store, open_store
from storage.urls.registry import MAP_STORES, STORES
from tests.support.documents import script, table, text_of
from tests.support.storage.full_store import fill, fill_maps

PAGE = "docs/stores.md"


def test_the_stores_are_those_of_the_code() -> None:
    rows = table(PAGE, "ppaas up", "URL", "backend")
    for option, backends in (("--store", STORES), ("--map-store", MAP_STORES)):
        found = {
            url.partition(":")[0]: re.search(r"\.\[(\w+)\]", backend)
            for listed, url, backend in rows
            if listed == option
        }
        assert {name: extra and extra[1] for name, extra in found.items()} == {
            name: backends.load(name).extra for name in backends.names()
        }


def test_the_commands_move_both_stores(tmp_path: Path) -> None:
    assert "ppaas.sqlite" in Path(server.__file__).read_text(encoding="utf-8")
    store = open_store(f"sqlite://{tmp_path / 'var' / 'ppaas.sqlite'}")
    fill(store, plans=5, robots=3)
    store.close()
    fill_maps(open_map_store(f"file://{tmp_path / 'var' / 'maps'}"))
    environment = os.environ | {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
    typed = ["bash", "-c", "set -euo pipefail\n" + script(PAGE)]
    ended = subprocess.run(typed, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert '"copied": 0' in ended.stdout and "differs" not in ended.stdout
    assert [head.id for head in open_map_store(f"file://{tmp_path / 'moved' / 'maps'}").maps()] == ["alone", "house"]


def test_the_options_are_those_of_the_code() -> None:
    named = set(re.findall(r"--\w[\w-]*", text_of(PAGE)))
    assert named == {
        "--store", "--map-store", "--json", "--overwrite", "--ready-file", "--linger",
        "--store-file", "--map-store-file", "--allow",
    }  # fmt: skip
