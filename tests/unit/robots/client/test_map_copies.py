"""Copies of maps: a fetch overwrites only files that a fetch made.

The kind, and its members: two maps whose images have one name; a user's own YAML file, image or octomap of the same
name; a copy that was edited; links and folders in the way; names that are no names of images (hidden files, programs,
the YAML file itself); notes that are lost or broken. A fetch that is refused writes nothing at all.
"""

import os
from pathlib import Path

import pytest

from ppaas.errors import Conflict, InvalidInput
from robots.client.map_copies import FULL_OCTREE, NOTES, MapCopies
from tests.support.storage.records import YAML, pgm


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
