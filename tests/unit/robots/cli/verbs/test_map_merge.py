"""``ppaas map merge``: maps of files, and maps of a cloud."""

import json
from pathlib import Path

import pytest

from endpoints.rest.maps import map_merge, merge_program
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.mapping.serialization.mapping_file import unpack_mapping
from robots.client.map_files import read_map_file
from tests.support.cloud.command_line import CommandLine
from tests.support.storage.mapped_maps import map_files, put_mapping
from tests.support.world.mappings import room_mapping
from tests.support.world.merge_drives import first_mapping, second_mapping


def save(folder: Path, name: str, mapping: Mapping) -> Path:
    """Write the files of a map; return its YAML file."""
    for part, data in map_files(mapping, name).items():
        (folder / f"{name}.{'pgm' if part == 'image' else part}").write_bytes(data)
    return folder / f"{name}.yaml"


async def test_maps_in_files_become_one(ppaas: CommandLine, tmp_path: Path) -> None:
    north, south = save(tmp_path, "north", first_mapping()), save(tmp_path, "south", second_mapping())
    merged = await ppaas("map", "merge", str(north), str(south), "--into", str(tmp_path / "both.yaml"), "--json")
    assert merged.status == 0, merged.err
    answer = json.loads(merged.out)
    mapping = unpack_mapping((tmp_path / "both.posegraph").read_bytes())
    count = len(first_mapping().frames) + len(second_mapping().frames)
    assert len(mapping.frames) == answer["key_frames"] == count
    assert read_map_file(tmp_path / "both.yaml").info.resolution == 0.05
    assert answer["places"] >= 3


async def test_maps_of_a_cloud_become_one(ppaas: CommandLine, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(map_merge, "merge_in_process", merge_program.merge_to)
    for name, mapping in (("north", first_mapping()), ("south", second_mapping())):
        put_mapping(ppaas.services.map_store, name, mapping)
    merged = await ppaas("map", "merge", "north", "south", "--into", "north", "--message", "both robots", "--json")
    assert merged.status == 0, merged.err
    answer = json.loads(merged.out)
    assert (answer["id"], answer["message"], answer["parts"]) == (
        "north",
        "both robots",
        ["image", "posegraph", "yaml"],
    )


async def test_maps_that_do_not_fit_leave_no_file(ppaas: CommandLine, tmp_path: Path) -> None:
    north, room = save(tmp_path, "north", first_mapping()), save(tmp_path, "room", room_mapping(40))
    both = tmp_path / "both.yaml"
    refused = await ppaas("map", "merge", str(north), str(room), "--into", str(both))
    assert refused.status == 1
    assert refused.err.startswith("ppaas: maps-not-merged: too few places")
    assert not both.exists()
    assert not both.with_suffix(".posegraph").exists()


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("a.yaml", "b", "--into", "c"), "give A, B and C all as ids, or all as .yaml files"),
        (("a.yaml", "b.yaml", "--into", "c.posegraph"), "use --into c.yaml"),
        (("a.yaml", "b.yaml", "--into", "none/c.yaml"), "there is no folder none"),
        (("a.yaml", "b.yaml", "--into", "c.yaml"), "cannot read the pose graph of a.yaml"),
    ],
)
async def test_wrong_files_are_refused_before_the_merge(ppaas: CommandLine, words: tuple[str, ...], why: str) -> None:
    refused = await ppaas("map", "merge", *words)
    assert refused.status == 1
    assert why in refused.err
