"""Commands of maps.md work, and its numbers are those of the code."""

import hashlib
import struct
from pathlib import Path

import numpy as np
import pytest

from endpoints.resources.services import MIB, RequestLimits
from ppaas.maps.formats.pictures import MAX_PIXELS
from ppaas.maps.octomap import binary_octomap
from ppaas.maps.octree import octree_of
from ppaas.maps.voxels import VoxelGrid, VoxelInfo
from storage.records import MapFile
from storage.versions import map_version
from tests.support.cloud.cloud import RunningCloud
from tests.support.documents import run_shell, script, table, text_of
from tests.support.endpoints.fuzzed_rest import description
from tests.support.sources import ROOT
from tests.unit.storage.files.test_store import MEMORY_LIMIT, SIDE

MAPS = "docs/maps.md"
OFFICE = ROOT / "docs" / "examples"


def version_of(yaml: bytes, image: bytes) -> str:
    files = {"yaml": yaml, "image": image}
    return map_version({name: MapFile(hashlib.sha256(data).hexdigest(), len(data)) for name, data in files.items()})


def test_the_operations_are_those_of_the_service() -> None:
    names = {"map_id": "ID", "version": "V", "number": "N", "robot": "R", "task_id": "T"}
    known = [path for path in description()["paths"] if path.startswith("/v1/maps")]
    paths = {path.format(**names) for path in known}
    for operation, _ in table(MAPS, "operation", "what it does"):
        path = operation.replace("`", "").split()[1].rstrip(",").partition("?")[0]
        assert path in paths, operation


def test_the_numbers_are_those_of_the_code() -> None:
    text = text_of(MAPS)
    assert f"{RequestLimits().max_upload // MIB} MiB" in text
    assert f"{MAX_PIXELS // 1_000_000} million pixels" in text
    assert f"{SIDE}² cells" in text and f"in {MEMORY_LIMIT // MIB} MiB" in text


@pytest.mark.journey
def test_the_shell_commands_work(cloud: RunningCloud, tmp_path: Path) -> None:
    yaml, image = (OFFICE / "office.yaml").read_bytes(), (OFFICE / "office.pgm").read_bytes()
    older = image[:-1] + bytes([255 - image[-1]])
    (tmp_path / "office.pgm").write_bytes(older)
    (tmp_path / "office.yaml").write_bytes(yaml)
    tree = binary_octomap(octree_of(VoxelGrid(np.full((1, 1, 2), 100, np.uint8), VoxelInfo(0.1, 2, 1, 1))))
    (tmp_path / "hall.bt").write_bytes(tree)
    (tmp_path / "cave.ot").write_bytes(
        b"# Octomap OcTree file\nid OcTree\nsize 1\nres 0.1\ndata\n" + struct.pack("<fB", 1.0, 0)
    )
    (tmp_path / "hall.yaml").write_bytes(yaml)
    [login] = [line for line in script("README.md").splitlines() if line.startswith("export PPAAS_TOKEN")]
    code = script(MAPS).replace("3f2a91c0", version_of(yaml, older)[:8]).replace(
        "b71d0c55", version_of(yaml, image)[:8]
    )  # fmt: skip
    printed = run_shell(f"{login}\nppaas map publish office.yaml\n{code}", tmp_path, cloud)
    assert "as surveyed in May" in printed
    assert "1×1 at (" in printed
    assert (tmp_path / "change.png").is_file()
    assert (tmp_path / "before" / "office.pgm").read_bytes() == older
    assert (tmp_path / "copies" / "hall.bt").read_bytes() == tree
