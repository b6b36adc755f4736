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

from ppaas.errors import InvalidInput, InvalidMap
from ppaas.maps.formats.map_yaml import Rules
from robots.client.map_files import (
    files_to_publish,
    find_map_files,
    map_id_of,
    read_map_file,
    read_map_files,
    yaml_of,
)
from storage.names import is_name

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
