"""Commands of backup.md work, and its options are those of the code."""

import os
import re
import subprocess
import sys
from pathlib import Path

from storage.urls.opening import open_map_store, open_store
from tests.support.documents import script, text_of
from tests.support.storage.full_store import fill, fill_maps

PAGE = "docs/backup.md"


def test_the_commands_back_up_and_restore(tmp_path: Path) -> None:
    store = open_store(f"sqlite://{tmp_path / 'var' / 'ppaas.sqlite'}")
    fill(store, plans=5, robots=3)
    store.close()
    fill_maps(open_map_store(f"file://{tmp_path / 'var' / 'maps'}"))
    recording = Path("recordings", "ann", "tb1", "20261126T224142Z.mcap")
    for name in (recording, Path("machines", "authority.key")):
        (tmp_path / "var" / name).parent.mkdir(parents=True)
        (tmp_path / "var" / name).write_bytes(b"content")
    environment = os.environ | {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
    typed = ["bash", "-c", "set -euo pipefail\n" + script(PAGE)]
    ended = subprocess.run(typed, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert "0 damaged" in ended.stdout and "differs" not in ended.stdout
    assert [head.id for head in open_map_store(f"file://{tmp_path / 'restored' / 'maps'}").maps()] == ["alone", "house"]
    assert (tmp_path / "restored" / recording).read_bytes() == b"content"
    assert (tmp_path / "restored" / "machines" / "authority.key").read_bytes() == b"content"


def test_the_options_are_those_of_the_commands() -> None:
    named = set(re.findall(r"--\w[\w-]*", text_of(PAGE)))
    known: set[str] = set()
    for command in (["backup", "create"], ["backup", "remove"], ["restore"], ["store", "check"], ["bench", "backup"]):
        printed = subprocess.run(
            [sys.executable, "-m", "robots.cli", *command, "--help"], capture_output=True, text=True, check=True
        )
        known |= set(re.findall(r"--\w[\w-]*", printed.stdout))
    assert named <= known
