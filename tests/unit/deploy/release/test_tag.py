"""A tag is released if all files of its commit name its version."""

from collections.abc import Callable
from pathlib import Path

import pytest

from deploy.release import tag
from ppaas.errors import Conflict, InvalidInput, NotFound

CHANGES = """# Changes

## [1.2.0] - 2026-11-30

### Added

- One.

## [1.1.0] - 2026-01-02

- Two.
"""
FILES = {
    "pyproject.toml": '[project]\nversion = "1.2.0"\n',
    "deploy/helm/ppaas/Chart.yaml": "version: 1.2.0\nappVersion: 1.2.0\n",
    "SECURITY.md": "| 1.2 | yes |\n",
    "CHANGELOG.md": CHANGES,
}


@pytest.fixture
def checkout(commit: Callable[..., Path]) -> Path:
    """Return a checkout of the tag v1.2.0, whose files fit."""
    return commit(FILES, tag="v1.2.0")


def test_a_tag_whose_files_fit_is_released(checkout: Path) -> None:
    assert tag.check("v1.2.0", checkout) == "1.2.0"


@pytest.mark.parametrize("name", ["1.2.0", "v1.2.0 ", "v01.2.0", "vnext", "v1.2.0-rc1", ""])
def test_a_tag_of_another_form_is_refused(name: str) -> None:
    with pytest.raises(InvalidInput, match=r"v0\.2\.0"):
        tag.version_of(name)


@pytest.mark.parametrize(
    ("name", "before", "after", "reason"),
    [
        ("pyproject.toml", "1.2.0", "1.3.0", "pyproject.toml is 1.3.0, not 1.2.0"),
        ("deploy/helm/ppaas/Chart.yaml", "appVersion: 1.2.0", "appVersion: 1.1.0", "appVersion of Chart.yaml is 1.1.0"),
        ("deploy/helm/ppaas/Chart.yaml", "version: 1.2.0\na", "version: 1.1.0\na", "version of Chart.yaml is 1.1.0"),
        ("SECURITY.md", "1.2", "1.1", r"no row \| 1.2 \| yes \|"),
        ("CHANGELOG.md", "2026-11-30", "unreleased", "'unreleased', not by a day"),
        ("CHANGELOG.md", "### Added\n\n- One.\n", "", "section of 1.2.0 in CHANGELOG.md is empty"),
        ("CHANGELOG.md", "[1.2.0]", "[1.2.1]", "section of CHANGELOG.md '1.2.0'"),
    ],
)
def test_a_file_of_another_version_is_named(
    commit: Callable[..., Path], name: str, before: str, after: str, reason: str
) -> None:
    text = FILES[name]
    assert text.count(before) == 1
    checkout = commit(FILES | {name: text.replace(before, after)}, tag="v1.2.0")
    with pytest.raises(Conflict, match=reason):
        tag.check("v1.2.0", checkout)


def test_another_commit_than_the_tag_is_refused(checkout: Path, commit: Callable[..., Path]) -> None:
    commit({"new": ""})
    with pytest.raises(Conflict, match=r"v1\.2\.0 is another commit"):
        tag.check("v1.2.0", checkout)


def test_changed_files_are_refused(checkout: Path) -> None:
    (checkout / "SECURITY.md").write_text(FILES["SECURITY.md"] + "more\n")
    with pytest.raises(Conflict, match=r"1 changed files, such as SECURITY\.md"):
        tag.check("v1.2.0", checkout)


def test_a_missing_tag_is_refused_with_all_other_reasons(checkout: Path) -> None:
    with pytest.raises(Conflict, match=r"pyproject\.toml is 1\.2\.0.*there is no tag v1\.3\.0"):
        tag.check("v1.3.0", checkout)


def test_the_notes_are_the_section_of_the_version() -> None:
    assert tag.section(CHANGES, "1.2.0") == ("2026-11-30", "### Added\n\n- One.")
    assert tag.section(CHANGES, "1.1.0") == ("2026-01-02", "- Two.")
    with pytest.raises(NotFound):
        tag.section(CHANGES, "1.0.0")
