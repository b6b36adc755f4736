"""Map files of users: the paths and names that map_server finds, and plain advice for all others.

The kind, and its members: image paths with ``./``, folders, ``..``, blanks, an absolute path, a home folder, bytes of
another code page; endings in upper case, and ``.yml``; the image in place of its YAML file; a path of another computer,
whose image lies beside; names that cannot be the id of a map; maps of MovingAI.
"""

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import Conflict, InvalidInput, InvalidMap
from ppaas.maps.formats.map_yaml import Rules
from robots.client.map_copies import FULL_OCTREE, NOTES, MapCopies
from robots.client.map_files import (
    files_to_publish,
    find_map_files,
    map_id_of,
    read_map_file,
    read_map_files,
    yaml_of,
)
from storage.names import is_name
from tests.support.storage.records import YAML, pgm

IMAGE = b"P2 2 1 255 0 254"


def map_of(folder: Path, image: str | bytes, *, name: str = "a.yaml") -> Path:
    """Write a YAML file that names an image."""
    file = folder / name
    file.write_bytes(b"image: %b\nresolution: 1.0\norigin: [0, 0, 0]\n" % os.fsencode(image))
    return file


@pytest.mark.parametrize(
    "image",
    ["a.pgm", "./a.pgm", "images/a.pgm", "images/../a.pgm", "../a.pgm", "my maps/2nd floor (new).PGM", "'a#1.pgm'"],
)
def test_the_image_is_found_from_the_folder_of_the_yaml(tmp_path: Path, image: str) -> None:
    folder = tmp_path / "maps"
    for each in (folder / "images", folder / "my maps"):
        each.mkdir(parents=True)
    path = folder / image.strip("'")
    path.write_bytes(IMAGE)
    assert read_map_files(map_of(folder, image))[1] == IMAGE


def test_absolute_paths_and_paths_of_the_home_are_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(tmp_path / "user"))
    (tmp_path / "user").mkdir()
    (tmp_path / "user" / "a.pgm").write_bytes(IMAGE)
    assert read_map_files(map_of(tmp_path, f"{tmp_path}/user/a.pgm"))[1] == IMAGE
    assert read_map_files(map_of(tmp_path, "~/a.pgm"))[1] == IMAGE


def test_a_name_in_another_code_page_is_found_by_its_bytes(tmp_path: Path) -> None:
    name = "Büro.pgm".encode("latin-1")
    (tmp_path / os.fsdecode(name)).write_bytes(IMAGE)
    assert read_map_files(map_of(tmp_path, name))[1] == IMAGE


def test_an_image_beside_is_named_where_the_path_is_of_another_computer(tmp_path: Path) -> None:
    (tmp_path / "a.pgm").write_bytes(IMAGE)
    with pytest.raises(InvalidMap, match=r"'/nowhere/maps/a\.pgm' does not exist; '.*a\.pgm' does: write"):
        find_map_files(map_of(tmp_path, "/nowhere/maps/a.pgm"))
    with pytest.raises(InvalidMap, match=r"write `image: a\.pgm`"):
        find_map_files(map_of(tmp_path, "C:\\maps\\a.pgm"))
    with pytest.raises(InvalidMap, match=r"b\.pgm' does not exist$"):
        find_map_files(map_of(tmp_path, "b.pgm"))


@pytest.mark.parametrize("ending", [".yaml", ".yml", ".YAML"])
@pytest.mark.parametrize("image", ["a.pgm", "a.PGM", "a.Png", "a.bmp", "a.jpeg", "a.tif"])
def test_a_map_may_be_named_by_its_image(tmp_path: Path, ending: str, image: str) -> None:
    record = map_of(tmp_path, "a.pgm", name=f"a{ending}")
    (tmp_path / "a.pgm").write_bytes(IMAGE)
    assert yaml_of(tmp_path / image) == yaml_of(record) == record
    assert find_map_files(tmp_path / image) == (record.read_bytes(), tmp_path / "a.pgm")


def test_an_image_without_a_yaml_file_is_refused_with_advice(tmp_path: Path) -> None:
    (tmp_path / "a.pgm").write_bytes(IMAGE)
    assert yaml_of(tmp_path / "a.pgm") == tmp_path / "a.yaml"
    with pytest.raises(InvalidMap, match=r"'a\.pgm' is an image: give the YAML file .*; there is no .*a\.yaml"):
        find_map_files(tmp_path / "a.pgm")


@pytest.mark.parametrize(
    ("name", "suggested"),
    [
        ("2nd floor (new).yaml", "2nd-floor-new"),
        (".hidden.yaml", "hidden"),
        ("Büro.yaml", "B-ro"),
        ("地图.yaml", "map"),
        ("-.yaml", "map"),
        ("a" * 70 + ".yaml", "a" * 64),
    ],
)
def test_a_name_that_is_no_id_is_refused_with_a_suggestion(name: str, suggested: str) -> None:
    with pytest.raises(InvalidInput, match=rf"choose one with --id NAME, as --id {suggested}$"):
        map_id_of(Path(name))


@given(st.text(min_size=1, max_size=80).filter(lambda text: not {"/", "\0"} & set(text)))
def test_every_id_is_one_that_the_cloud_takes(name: str) -> None:
    try:
        assert is_name(map_id_of(Path(f"{name}.yaml")))
    except InvalidInput as error:
        assert is_name(str(error).rpartition(" ")[2])


def test_the_rules_may_be_given(tmp_path: Path) -> None:
    record = map_of(tmp_path, "a.pgm")
    (tmp_path / "a.pgm").write_bytes(IMAGE)
    assert read_map_file(record).data.tolist() == [[100, 0]]
    with pytest.raises(InvalidMap, match="Nav2"):
        read_map_file(record, Rules.NAV2)


@pytest.mark.parametrize("name", ["tiny.map", "TINY.MAP"])
def test_a_map_of_movingai_is_read_and_converted(tmp_path: Path, name: str) -> None:
    file = tmp_path / name
    file.write_bytes(b"type octile\r\nheight 2\r\nwidth 3\r\nmap\r\n.@.\r\n...\r\n")
    grid = read_map_file(file)
    assert grid.data.tolist() == [[0, 100, 0], [0, 0, 0]]
    record, image = files_to_publish(file)
    assert isinstance(image, bytes)
    (tmp_path / "copy.yaml").write_bytes(record)
    (tmp_path / f"{file.stem}.pgm").write_bytes(image)
    copy = read_map_file(tmp_path / "copy.yaml")
    assert np.array_equal(copy.data, grid.data)
    assert copy.info == grid.info


def test_a_broken_or_missing_map_of_movingai_is_refused(tmp_path: Path) -> None:
    (tmp_path / "words.map").write_bytes(b"words")
    with pytest.raises(InvalidMap, match="not a MovingAI map"):
        read_map_file(tmp_path / "words.map")
    with pytest.raises(InvalidMap, match="cannot read the map"):
        read_map_file(tmp_path / "none.map")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return the folder of the copies."""
    (tmp_path / "copies").mkdir()
    return tmp_path / "copies"


def fetched(folder: Path, map_id: str, *, image: str = "map.pgm", grey: int = 254, octomap: bytes = b"") -> list[str]:
    """Keep a map as if it had been downloaded; return the names of its files."""
    parts = {"yaml": YAML.replace(b"house.pgm", image.encode()), "image": pgm(value=grey), "octomap": octomap}
    downloads = folder.parent / "downloads"
    downloads.mkdir(exist_ok=True)
    for name, data in parts.items():
        (downloads / name).write_bytes(data)
    files = {name: downloads / name for name, data in parts.items() if data}
    return [path.name for path in MapCopies(folder, map_id).keep(files)]


def contents(folder: Path) -> dict[str, bytes]:
    return {file.name: Path(file).read_bytes() for file in os.scandir(folder) if file.is_file()}


def test_files_are_kept_byte_for_byte_and_can_be_fetched_again(folder: Path) -> None:
    assert fetched(folder, "hall") == ["hall.yaml", "map.pgm"]
    assert (folder / "hall.yaml").read_bytes() == YAML.replace(b"house.pgm", b"map.pgm")
    assert fetched(folder, "hall", grey=0) == ["hall.yaml", "map.pgm"]
    assert (folder / "map.pgm").read_bytes() == pgm(value=0)


def test_a_second_map_with_the_same_image_name_gets_an_image_of_its_own(folder: Path) -> None:
    fetched(folder, "hall", grey=1)
    assert fetched(folder, "cave", grey=2) == ["cave.yaml", "cave.pgm"]
    assert fetched(folder, "cell", grey=1) == ["cell.yaml", "cell.pgm"]  # equal for now, but another map
    assert b"image: cave.pgm" in (folder / "cave.yaml").read_bytes()
    assert (folder / "map.pgm").read_bytes() == pgm(value=1)
    assert fetched(folder, "cave", grey=3) == ["cave.yaml", "cave.pgm"]
    assert fetched(folder, "hall", grey=4) == ["hall.yaml", "map.pgm"]


@pytest.mark.parametrize(
    ("image", "name"),
    [("./map.pgm", "map.pgm"), ("images/map.pgm", "map.pgm"), ("/maps/map.PGM", "map.PGM"), ("../map.jpg", "map.jpg")],
)
def test_the_image_is_put_beside_and_the_record_says_so(folder: Path, image: str, name: str) -> None:
    assert fetched(folder, "hall", image=image) == ["hall.yaml", name]
    expected = image if image.startswith("./") else name
    assert (folder / "hall.yaml").read_bytes() == YAML.replace(b"house.pgm", expected.encode())


@pytest.mark.parametrize(
    "image", ["..", ".bashrc", ".map.pgm", "run.sh", "hall.yaml", "map", '"a\\tb.pgm"', "a/", NOTES]
)
def test_a_name_that_is_not_an_images_is_not_used(folder: Path, image: str) -> None:
    assert fetched(folder, "hall", image=image) == ["hall.yaml", "hall.pgm"]
    assert b"image: hall.pgm" in (folder / "hall.yaml").read_bytes()
    assert set(contents(folder)) == {"hall.yaml", "hall.pgm", NOTES}
    assert fetched(folder, "hall", image=image) == ["hall.yaml", "hall.pgm"]


@pytest.mark.parametrize("name", ["hall.yaml", "hall.bt"])
def test_files_of_others_are_not_written_over_and_nothing_is_written(folder: Path, name: str) -> None:
    (folder / name).write_bytes(b"mine")
    with pytest.raises(Conflict, match=rf"{name} exists, and no fetch of map 'hall' made it as it is: move it away"):
        fetched(folder, "hall", octomap=b"# Octomap OcTree binary file\n")
    assert contents(folder) == {name: b"mine"}


def test_an_image_of_others_is_kept_under_the_name_of_the_map(folder: Path) -> None:
    (folder / "map.pgm").write_bytes(b"mine")
    assert fetched(folder, "hall") == ["hall.yaml", "hall.pgm"]
    assert (folder / "map.pgm").read_bytes() == b"mine"
    (folder / "map2.pgm").write_bytes(b"mine")
    (folder / "cave.pgm").write_bytes(b"mine")
    before = contents(folder)
    with pytest.raises(Conflict, match=r"cave\.pgm exists"):
        fetched(folder, "cave", image="map2.pgm")
    assert contents(folder) == before


def test_a_copy_that_was_changed_is_not_written_over(folder: Path) -> None:
    fetched(folder, "hall")
    (folder / "hall.yaml").write_bytes(b"edited")
    with pytest.raises(Conflict, match="made it as it is"):
        fetched(folder, "hall", grey=3)
    assert (folder / "map.pgm").read_bytes() == pgm()


@pytest.mark.parametrize("notes", [None, b"", b"[]", b'{"map.pgm": 1}'])
def test_without_notes_equal_files_are_taken_for_copies(folder: Path, notes: bytes | None) -> None:
    fetched(folder, "hall")
    if notes is None:
        (folder / NOTES).unlink()
    else:
        (folder / NOTES).write_bytes(notes)
    assert fetched(folder, "hall") == ["hall.yaml", "map.pgm"]
    assert fetched(folder, "hall", grey=2) == ["hall.yaml", "map.pgm"]


def test_links_and_folders_are_left_alone(folder: Path) -> None:
    (folder / "map.pgm").symlink_to(folder.parent / "nowhere")
    assert fetched(folder, "hall") == ["hall.yaml", "hall.pgm"]
    (folder / "cave.yaml").mkdir()
    with pytest.raises(Conflict):
        fetched(folder, "cave")


@pytest.mark.parametrize(("line", "name"), [(FULL_OCTREE, "hall.ot"), (b"# Octomap OcTree binary file", "hall.bt")])
def test_an_octomap_gets_the_ending_of_its_kind(folder: Path, line: bytes, name: str) -> None:
    assert fetched(folder, "hall", octomap=line + b"\nid OcTree\n") == ["hall.yaml", "map.pgm", name]


def test_a_folder_that_cannot_be_written_is_reported(folder: Path) -> None:
    (folder / NOTES).mkdir()
    with pytest.raises(InvalidInput, match="cannot write map 'hall' to"):
        fetched(folder, "hall")
