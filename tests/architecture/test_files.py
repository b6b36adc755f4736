"""Files around the code: their folders, and content that they must not have."""

import re

import pytest

from tests.support.sources import ALL_PACKAGES, ROOT, tracked_files

MACHINE_PATH = re.compile(rb"(?<![\w.])/(?:home|root|Users|work)/\w")
LINK = re.compile(r"(?<!!)\[[^\]]*\]\((?!\w+:|#)([^)#\s]+)")
ANCHOR = re.compile(r"(?<!!)\[[^\]]*\]\((?!\w+:)([^)#\s]*)#([^)\s]+)\)")
HEADING = re.compile(r"^#+ (.*)$", re.MULTILINE)
CODE_BLOCK = re.compile(r"^( *)```.*?^\1```$", re.MULTILINE | re.DOTALL)
FOLDER = re.compile(r"^\| `([\w/]+)/` \|", re.MULTILINE)
DOCUMENTS = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]


@pytest.fixture
def tracked():
    """Return the files tracked by git."""
    return tracked_files() or pytest.skip("no git checkout")


def test_docker_folder_is_not_a_package():
    assert not (ROOT / "docker" / "__init__.py").exists(), "the name docker belongs to the Docker SDK"


def test_test_folders_are_not_packages():
    assert not list((ROOT / "tests").rglob("__init__.py"))


def test_every_folder_of_code_is_a_package():
    folders = {file.parent for package in ALL_PACKAGES for file in (ROOT / package).rglob("*.py")}
    assert [folder for folder in folders if not (folder / "__init__.py").exists()] == []


def test_no_file_names_a_path_of_one_machine(tracked):
    found = ((file, MACHINE_PATH.search(file.read_bytes())) for file in tracked)
    assert [f"{file.relative_to(ROOT)}: {match.group()!r}" for file, match in found if match] == []


def test_machine_path_pattern_finds_home_folders():
    assert MACHINE_PATH.search(b"cd /home/" + b"someone")
    assert not MACHINE_PATH.search(b"https://example.org/home/page")


def test_architecture_lists_exactly_the_folders_of_the_code():
    described = FOLDER.findall((ROOT / "docs" / "architecture.md").read_text(encoding="utf-8"))
    inits = (init for package in ALL_PACKAGES for init in (ROOT / package).rglob("__init__.py"))
    folders = {init.parent.relative_to(ROOT).as_posix() for init in inits if init.parent.name != "kernels"}
    assert len(described) == len(set(described))
    assert {folder for folder in described if folder.partition("/")[0] in ALL_PACKAGES} == folders


def test_every_folder_named_in_the_architecture_exists():
    described = FOLDER.findall((ROOT / "docs" / "architecture.md").read_text(encoding="utf-8"))
    assert [folder for folder in described if not (ROOT / folder).is_dir()] == []


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda file: file.relative_to(ROOT).as_posix())
def test_every_link_has_a_target(document):
    links = LINK.findall(document.read_text(encoding="utf-8"))
    assert [link for link in links if not (document.parent / link).exists()] == []


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda file: file.relative_to(ROOT).as_posix())
def test_every_anchor_of_a_link_is_a_heading(document):
    links = ANCHOR.findall(document.read_text(encoding="utf-8"))
    pages = {
        name: document.parent / name if name else document for name, _ in links if not name or name.endswith(".md")
    }
    headings = {name: anchors(page.read_text(encoding="utf-8")) for name, page in pages.items()}
    assert [f"{name}#{anchor}" for name, anchor in links if anchor not in headings.get(name, {anchor})] == []


def test_anchors_of_headings_are_spelled_as_on_github():
    assert anchors("# One `two`, three\n```sh\n# four\n```\n## [Five](a.md)/six") == {"one-two-three", "fivesix"}


def anchors(text):
    """Return the anchors of a document's headings, as GitHub makes them."""
    headings = HEADING.findall(CODE_BLOCK.sub("", text))
    titles = (re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading) for heading in headings)
    return {re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-") for title in titles}
