import json
import os
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ppaas.maps.octomap import binary_octomap
from ppaas.maps.octree import octree_of
from ppaas.maps.voxels import VoxelGrid, VoxelInfo
from robots.client.map_files import read_map_files
from tests.support.cloud.command_line import CommandLine
from tests.support.storage.records import YAML, pgm, put_map
from tests.support.storage.records import house as house_map


@pytest.fixture
def coarse(house: Path) -> Path:
    """Return the same map with larger cells."""
    file = house.with_name("coarse.yaml")
    file.write_bytes(house.read_bytes().replace(b"0.05", b"0.1"))
    return file


@pytest.fixture
def broken(house: Path) -> Path:
    """Return a map with a truncated image."""
    image = house.with_suffix(".pgm")
    image.write_bytes(image.read_bytes()[:-1])
    return house


def edit(file: Path) -> bytes:
    """Append a comment to a file; return its content."""
    content = file.read_bytes() + b"# edited\n"
    file.write_bytes(content)
    return content


def renamed(file: Path, name: str) -> Path:
    """Rename a file in its folder; return its new path."""
    return file.rename(file.with_name(name))


async def test_a_map_is_published_listed_shown_and_deleted(ppaas: CommandLine, house: Path) -> None:
    published = await ppaas("map", "publish", str(house))
    assert published.status == 0, published.err
    expected = ["id", "owner", "version", "width", "height", "resolution", "origin", "readers", "description"]
    assert published.rows[0] == [*expected, "traffic", "georeference"]
    assert published.rows[1][:2] == ["house", "ann"]
    assert published.rows[1][3:] == ["4", "3", "0.05", "-1,", "-2,", "0", "-", "no", "-"]
    assert (await ppaas("map", "show", "house")).out == published.out
    assert (await ppaas("map", "list")).rows[1][:2] == ["house", "ann"]
    assert (await ppaas("map", "delete", "house")).status == 0
    assert (await ppaas("map", "list")).out == "no maps that you may use; publish one: ppaas map publish FILE.yaml\n"


async def test_a_map_is_published_with_the_given_id_and_readers(ppaas: CommandLine, house: Path) -> None:
    await ppaas("map", "publish", str(house), "--id", "home", "--reader", "bob", "--reader", "admin")
    [listed] = json.loads((await ppaas("map", "list", "--json", user="bob")).out)
    assert (listed["id"], listed["readers"]) == ("home", ["bob", "admin"])
    assert len(listed["version"]) == 64


async def test_publishing_again_creates_a_new_version(ppaas: CommandLine, house: Path, coarse: Path) -> None:
    first = json.loads((await ppaas("map", "publish", str(house), "--json")).out)
    second = json.loads((await ppaas("map", "publish", str(coarse), "--id", "house", "--json")).out)
    assert first["id"] == second["id"]
    assert first["version"] != second["version"]
    assert second["resolution"] == 0.1


async def test_a_map_is_private_until_shared_and_stays_its_owners(ppaas: CommandLine, house: Path) -> None:
    await ppaas("map", "publish", str(house))
    unknown = await ppaas("map", "show", "house", user="bob")
    assert (unknown.status, unknown.err) == (1, "ppaas: not-found: unknown map 'house'\n")
    await ppaas("map", "publish", str(house), "--reader", "*")
    assert (await ppaas("map", "show", "house", user="bob")).status == 0
    refused = await ppaas("map", "delete", "house", user="bob")
    assert (refused.status, refused.err[:22]) == (1, "ppaas: not-permitted: ")
    refused = await ppaas("map", "publish", str(house), user="bob")
    assert refused.err == "ppaas: conflict: map 'house' belongs to another user: choose another id\n"


@pytest.mark.parametrize(
    ("name", "content", "error"),
    [
        ("nowhere.yaml", None, "invalid-map: cannot read the map: "),
        ("image.yaml", b"image: nowhere.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n", "invalid-map: "),
        ("noise.yaml", b"\x00\xff", "invalid-map: "),
        ("list.yaml", b"[1, 2]", "invalid-map: "),
    ],
)
async def test_invalid_map_files_are_refused(
    ppaas: CommandLine, tmp_path: Path, name: str, content: bytes | None, error: str
) -> None:
    if content is not None:
        (tmp_path / name).write_bytes(content)
    ended = await ppaas("map", "publish", str(tmp_path / name))
    assert (ended.status, ended.out) == (1, "")
    assert ended.err.startswith(f"ppaas: {error}")


async def test_a_truncated_image_is_refused_by_the_cloud(ppaas: CommandLine, broken: Path) -> None:
    ended = await ppaas("map", "publish", str(broken))
    assert ended.err.startswith("ppaas: invalid-map: ")
    assert (await ppaas("map", "list", "--json")).out == "[]\n"


async def test_an_invalid_map_id_is_refused_with_the_rules(ppaas: CommandLine, house: Path) -> None:
    ended = await ppaas("map", "publish", str(house), "--id", "my house")
    assert ended.err.startswith("ppaas: invalid-input: 'my house' is not a valid name of a map: use")


async def test_a_map_is_published_with_the_rules_of_nav2(ppaas: CommandLine, house: Path, tmp_path: Path) -> None:
    assert (await ppaas("map", "publish", str(house), "--rules", "nav2")).status == 0
    assert (await ppaas("map", "fetch", "house", "--to", str(tmp_path / "got"))).status == 0
    assert b"rules: nav2" in (tmp_path / "got" / "house.yaml").read_bytes()


async def test_readers_and_description_are_changed(ppaas: CommandLine, house: Path) -> None:
    await ppaas("map", "publish", str(house), "--description", "the ground floor")
    changed = json.loads((await ppaas("map", "change", "house", "--reader", "bob", "--json")).out)
    assert (changed["readers"], changed["description"]) == (["bob"], "the ground floor")
    changed = json.loads((await ppaas("map", "change", "house", "--reader", "-", "--description", "", "--json")).out)
    assert (changed["readers"], changed["description"], changed["traffic"]) == ([], "", False)
    assert json.loads((await ppaas("map", "change", "house", "--traffic", "on", "--json")).out)["traffic"]
    assert not json.loads((await ppaas("map", "change", "house", "--traffic", "off", "--json")).out)["traffic"]
    assert "nothing to change" in (await ppaas("map", "change", "house")).err


async def test_every_version_is_listed_shown_and_fetched(
    ppaas: CommandLine, house: Path, coarse: Path, tmp_path: Path
) -> None:
    first = json.loads((await ppaas("map", "publish", str(house), "--json")).out)
    await ppaas("map", "publish", str(coarse), "--id", "house")
    newest, oldest = json.loads((await ppaas("map", "versions", "house", "--json")).out)
    assert (oldest["version"], newest["present"], oldest["present"]) == (first["version"], True, False)
    assert [row[-1] for row in (await ppaas("map", "versions", "house")).rows] == ["present", "yes", "no"]
    shown = json.loads((await ppaas("map", "show", "house", "--version", first["version"], "--json")).out)
    assert shown["resolution"] == 0.05
    fetched = await ppaas("map", "fetch", "house", "--version", first["version"], "--to", str(tmp_path / "old"))
    assert fetched.out.split() == [str(tmp_path / "old" / name) for name in ("house.yaml", "house.pgm")]
    assert read_map_files(tmp_path / "old" / "house.yaml") == read_map_files(house)


async def test_a_map_with_an_unsafe_image_path_is_fetched_under_a_safe_name(ppaas: CommandLine, tmp_path: Path) -> None:
    for name in (b"../house.pgm", b"/etc/house.pgm", b"..", b"evil.yaml", b".profile"):
        put_map(ppaas.services.map_store, house_map("evil", yaml=YAML.replace(b"house.pgm", name)))
        ended = await ppaas("map", "fetch", "evil", "--to", str(tmp_path / "to"))
        image = "house.pgm" if name.endswith(b"house.pgm") else "evil.pgm"
        assert ended.out.split() == [str(tmp_path / "to" / each) for each in ("evil.yaml", image)], ended.err
        assert read_map_files(tmp_path / "to" / "evil.yaml")[1] == pgm()
    assert [file.name for file in os.scandir(tmp_path)] == ["to"]


async def test_a_fetch_never_writes_over_files_that_it_did_not_make(ppaas: CommandLine, house: Path) -> None:
    await ppaas("map", "publish", str(house))
    folder, edited = house.parent, edit(house)
    refused = await ppaas("map", "fetch", "house", "--to", str(folder))
    assert refused.err.startswith(f"ppaas: conflict: {house} exists, and no fetch of map 'house' made it as it is: ")
    assert sorted(file.name for file in os.scandir(folder)) == ["house.pgm", "house.yaml"]
    assert edit(house) == edited + b"# edited\n"


async def test_a_map_is_published_by_its_image(ppaas: CommandLine, house: Path) -> None:
    ended = await ppaas("map", "publish", str(house.with_suffix(".pgm")), "--json")
    assert json.loads(ended.out)["parts"] == ["image", "yaml"], ended.err
    alone = house.with_name("alone.png")
    alone.write_bytes(b"")
    assert "'alone.png' is an image: give the YAML file" in (await ppaas("map", "publish", str(alone))).err


async def test_a_file_whose_name_is_no_id_needs_the_option_id(ppaas: CommandLine, house: Path) -> None:
    file = renamed(house, "2nd floor (new).yaml")
    assert "choose one with --id NAME, as --id 2nd-floor-new" in (await ppaas("map", "publish", str(file))).err
    assert (await ppaas("map", "publish", str(file), "--id", "2nd-floor-new")).status == 0


async def test_a_map_of_movingai_is_published_as_a_grid(ppaas: CommandLine, tmp_path: Path) -> None:
    (tmp_path / "tiny.map").write_bytes(b"type octile\nheight 2\nwidth 3\nmap\n.@.\n...\n")
    ended = json.loads((await ppaas("map", "publish", str(tmp_path / "tiny.map"), "--json")).out)
    assert (ended["id"], ended["width"], ended["height"], ended["resolution"]) == ("tiny", 3, 2, 1.0)


async def test_control_characters_of_descriptions_are_not_printed(ppaas: CommandLine, house: Path) -> None:
    await ppaas("map", "publish", str(house), "--description", "\x1b]0;owned\x07 \u202e")
    assert not {"\x1b", "\x07", "\u202e"} & set((await ppaas("map", "list")).out)


async def test_versions_list_author_time_and_message(ppaas: CommandLine, house: Path, coarse: Path) -> None:
    await ppaas("map", "publish", str(house), "--message", "as built")
    await ppaas("map", "publish", str(coarse), "--id", "house", "--message", "a wall came down", user="admin")
    newest, oldest = json.loads((await ppaas("map", "versions", "house", "--json")).out)
    assert (oldest["author"], oldest["message"]) == ("ann", "as built")
    assert (newest["author"], newest["message"], newest["restored"]) == ("admin", "a wall came down", False)
    assert newest["created"] > oldest["created"] > 1.7e9
    heading = (await ppaas("map", "versions", "house")).rows[0]
    assert heading == ["version", "created", "author", "message", "restored", "parts", "present"]


async def test_a_map_is_rolled_back_to_an_abbreviated_version(ppaas: CommandLine, house: Path, coarse: Path) -> None:
    first = json.loads((await ppaas("map", "publish", str(house), "--json")).out)["version"]
    await ppaas("map", "publish", str(coarse), "--id", "house")
    ended = await ppaas("map", "roll-back", "house", first[:12], "--message", "the wall is up again", "--json")
    assert ended.status == 0, ended.err
    assert json.loads(ended.out)["version"] == first
    listed = json.loads((await ppaas("map", "versions", "house", "--json")).out)
    assert [(one["restored"], one["message"]) for one in listed] == [
        (True, "the wall is up again"),
        (False, ""),
        (False, ""),
    ]
    unknown = await ppaas("map", "roll-back", "house", "zzz")
    assert unknown.err.startswith("ppaas: not-found: unknown version of map 'house': 'zzz'; known: ")
    assert (await ppaas("map", "roll-back", "house", first, user="bob")).err.startswith("ppaas: not-found: ")


async def test_a_map_is_published_only_if_the_expected_version_is_current(
    ppaas: CommandLine, house: Path, coarse: Path
) -> None:
    first = json.loads((await ppaas("map", "publish", str(house), "--json")).out)["version"]
    again = ("map", "publish", str(coarse), "--id", "house", "--if-match", first)
    assert (await ppaas(*again)).status == 0
    assert "not at version" in (await ppaas("map", "publish", str(house), "--if-match", first)).err


async def test_differences_of_versions_are_shown_and_drawn(ppaas: CommandLine, house: Path, tmp_path: Path) -> None:
    first = json.loads((await ppaas("map", "publish", str(house), "--json")).out)["version"]
    cells = bytearray(pgm())
    cells[-2:] = b"\x00\x00"  # the two in the lower right corner
    house.with_suffix(".pgm").write_bytes(cells)
    await ppaas("map", "publish", str(house))
    picture = tmp_path / "change.png"
    diff = await ppaas("map", "diff", "house", first[:8], "--plot", str(picture))
    assert diff.status == 0, diff.err
    shown = dict(zip(diff.out.split("\n")[0].split(), diff.out.split("\n")[1].split("  "), strict=False))
    assert shown["changed"].strip() == "2"
    found = json.loads((await ppaas("map", "diff", "house", first, "--json")).out)
    assert found["rectangle"] == {"column": 2, "row": 0, "width": 2, "height": 1}
    assert np.allclose(found["corners"], [[-0.9, -2.0], [-0.8, -2.0], [-0.8, -1.95], [-0.9, -1.95]])
    with Image.open(picture) as drawn:
        assert drawn.size == (4, 3)
        assert len(drawn.getcolors() or ()) > 1


async def test_an_octomap_is_published_with_or_without_a_grid_and_fetched(
    ppaas: CommandLine, house: Path, tmp_path: Path
) -> None:
    octree = tmp_path / "cave.BT"
    octree.write_bytes(binary_octomap(octree_of(VoxelGrid(np.full((1, 1, 1), 100, np.uint8), VoxelInfo(0.1, 1, 1, 1)))))
    ended = await ppaas("map", "publish", str(octree), "--json")
    assert ended.status == 0, ended.err
    assert (json.loads(ended.out)["parts"], json.loads(ended.out)["width"]) == (["octomap"], None)
    await ppaas("map", "publish", str(house), "--octomap", str(octree))
    for map_id, names in (("cave", ["cave.bt"]), ("house", ["house.yaml", "house.pgm", "house.bt"])):
        fetched = await ppaas("map", "fetch", map_id, "--to", str(tmp_path / "got"))
        assert fetched.out.split() == [str(tmp_path / "got" / name) for name in names]
        assert (tmp_path / "got" / f"{map_id}.bt").read_bytes() == octree.read_bytes()
    octree.write_bytes(octree.read_bytes()[:-1])
    broken = await ppaas("map", "publish", str(octree))
    assert broken.err.startswith("ppaas: invalid-map: the octree cannot be read")


async def test_a_version_is_deleted_by_a_prefix_unless_it_is_the_current_one(ppaas: CommandLine) -> None:
    old, current = (put_map(ppaas.services.map_store, house_map(image=pgm(value=value))).version for value in (0, 254))
    assert (await ppaas("map", "version", "delete", "house", old[:12])).status == 0
    assert [one.version for one in ppaas.services.map_store.versions("house")] == [current]
    refused = await ppaas("map", "version", "delete", "house", current)
    assert refused.err.startswith("ppaas: conflict: ")
    assert (await ppaas("map", "version", "delete", "house", "zzz")).err.startswith("ppaas: not-found: ")
