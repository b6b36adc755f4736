"""The files around the code: where they lie and what they must not say."""

import re

import pytest

from tests.support.sources import ALL_PACKAGES, ROOT, tracked_files

MACHINE_PATH = re.compile(rb"(?<![\w.])/(?:home|root|Users|work)/\w")
LINK = re.compile(r"(?<!!)\[[^\]]*\]\((?!\w+:|#)([^)#\s]+)")
ROOM = re.compile(r"^\| `([\w/]+)/` \|", re.MULTILINE)
DOCUMENTS = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]


@pytest.fixture
def tracked():
    """Return the files that git keeps."""
    return tracked_files() or pytest.skip("no git checkout")


def test_docker_is_no_package():
    assert not (ROOT / "docker" / "__init__.py").exists(), "the name docker belongs to the Docker SDK"


def test_tests_are_no_packages():
    assert not list((ROOT / "tests").rglob("__init__.py"))


def test_every_folder_of_code_is_a_package():
    folders = {file.parent for package in ALL_PACKAGES for file in (ROOT / package).rglob("*.py")}
    assert [folder for folder in folders if not (folder / "__init__.py").exists()] == []


def test_no_file_names_a_path_of_one_machine(tracked):
    found = ((file, MACHINE_PATH.search(file.read_bytes())) for file in tracked)
    assert [f"{file.relative_to(ROOT)}: {match.group()!r}" for file, match in found if match] == []


def test_the_search_for_paths_finds_them():
    assert MACHINE_PATH.search(b"cd /home/" + b"someone")
    assert not MACHINE_PATH.search(b"https://example.org/home/page")


def test_the_rooms_of_the_architecture_are_those_of_the_code():
    described = ROOM.findall((ROOT / "docs" / "architecture.md").read_text(encoding="utf-8"))
    inits = (init for package in ALL_PACKAGES for init in (ROOT / package).rglob("__init__.py"))
    rooms = {init.parent.relative_to(ROOT).as_posix() for init in inits if init.parent.name != "kernels"}
    assert len(described) == len(set(described))
    assert {room for room in described if room.partition("/")[0] in ALL_PACKAGES} == rooms


def test_the_folders_of_the_architecture_beside_the_code_exist():
    described = ROOM.findall((ROOT / "docs" / "architecture.md").read_text(encoding="utf-8"))
    assert [room for room in described if not (ROOT / room).is_dir()] == []


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda file: file.relative_to(ROOT).as_posix())
def test_every_link_leads_somewhere(document):
    links = LINK.findall(document.read_text(encoding="utf-8"))
    assert [link for link in links if not (document.parent / link).exists()] == []
