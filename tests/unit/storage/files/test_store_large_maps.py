"""Maps of 8192 × 8192 cells are published and read with a fraction of their size in memory."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.storage.records import YAML

SIDE = 8192
MEMORY_LIMIT = 32 << 20
"""Memory limit of a process beyond its size after all imports [bytes]: half of the size of the map's image."""

LIMITED = """
import resource, sys
from pathlib import Path
import numpy as np
from endpoints.rest.maps.content_check import check_contents
from ppaas.maps.formats.difference import difference
from ppaas.maps.formats.map_files import open_grid
from storage.staged_uploads import BLOCK, blocks
from storage.files.store import FileMapStore
from storage.records import Publication

folder, most = Path(sys.argv[1]), int(sys.argv[2])
store = FileMapStore(folder / "maps")
taken = int(Path("/proc/self/status").read_text().split("VmData:")[1].split()[0]) * 1024
resource.setrlimit(resource.RLIMIT_DATA, (taken + most, taken + most))

def read(path):
    with path.open("rb") as file:
        while block := file.read(BLOCK):
            yield block

def publish(name):
    with store.stage() as upload:
        upload.add("yaml", read(folder / "map.yaml"))
        upload.add("image", read(folder / name))
        check_contents(upload)
        return store.publish(upload, Publication("large", "ann", 1.0)).version

if sys.argv[3] == "stream":
    old, new = publish("old.pgm"), publish("new.pgm")
    with store.open_map("large", old) as before, store.open_map("large", new) as after:
        size = sum(len(block) for block in blocks(after.buffer("image")))
        found = difference(open_grid(*before.grid()), open_grid(*after.grid()))
    print(size, found.changed, *found.rectangle)
else:
    (folder / "old.pgm").read_bytes()
"""


@pytest.fixture(scope="module")
def large(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with two images that differ in a square."""
    folder = tmp_path_factory.mktemp("large")
    (folder / "map.yaml").write_bytes(YAML)
    header = b"P5\n%d %d\n255\n" % (SIDE, SIDE)
    (folder / "old.pgm").write_bytes(header + b"\xfe" * SIDE * SIDE)
    with (folder / "new.pgm").open("wb") as file:
        file.write(header + b"\xfe" * SIDE * SIDE)
        for row in range(100, 110):
            file.seek(len(header) + row * SIDE + 200)
            file.write(bytes(10))
    return folder


def limited(folder: Path, what: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", LIMITED, str(folder), str(MEMORY_LIMIT), what]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_a_map_is_published_read_and_compared_within_half_its_size(large: Path) -> None:
    ended = limited(large, "stream")
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.split() == [str(SIDE * SIDE + 17), "100", "200", str(SIDE - 110), "10", "10"]


def test_reading_the_whole_map_exceeds_the_limit(large: Path) -> None:
    assert "MemoryError" in limited(large, "whole").stderr
