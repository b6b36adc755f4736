"""Manual page ``ppaas(1)``: checked by the programs that print it."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from docs.site.man_page import NAME, main, man_page
from robots.cli.main import parser_of
from tests.support.commands import leaves

CHECKS = {
    "mandoc": ["mandoc", "-T", "lint", "-W", "warning"],
    "groff": ["groff", "-man", "-ww", "-T", "utf8", "-z"],
}


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the file of the page."""
    folder = tmp_path_factory.mktemp("man") / "man1"
    assert main([str(folder)]) == 0
    return folder / NAME


@pytest.mark.parametrize("program", CHECKS)
def test_a_reader_of_manual_pages_finds_no_fault(page: Path, program: str) -> None:
    if shutil.which(program) is None:
        pytest.skip(f"no {program} on this machine")
    ended = subprocess.run([*CHECKS[program], page], capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stdout + ended.stderr) == (0, "")


def test_every_command_and_option_is_in_the_page() -> None:
    plain = man_page().replace(r"\-", "-")
    headings = re.findall(r'^\.SS "(.*)"$', plain, re.MULTILINE)
    terms = re.findall(r'^\.B "(.*)"$', plain, re.MULTILINE)
    options = {option for term in terms for option in re.findall(r"--[\w-]+", term)}
    for leaf in leaves():
        assert any(f"{heading} ".startswith(f"{leaf.prog} ") for heading in headings), leaf.prog
        named = {option for action in leaf._actions for option in action.option_strings if option.startswith("--")}
        assert named - options <= {"--help"}, leaf.prog


def test_text_that_begins_with_a_control_character_is_printed(monkeypatch: pytest.MonkeyPatch) -> None:
    """A line that begins with an apostrophe or a dot is a request, which readers drop."""
    parser = parser_of([])
    parser.description = "'quoted' \\ words"
    monkeypatch.setattr("docs.site.man_page.parser_of", lambda _words: parser)
    assert "\n\\&'quoted' \\e words\n" in man_page()


def test_the_date_is_the_one_of_a_reproducible_build(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    assert man_page().startswith('.TH PPAAS 1 "2023-11-14" ')
