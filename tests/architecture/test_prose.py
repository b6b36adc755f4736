"""Docstrings and documents are written in plain English, as far as rules can check."""

import pytest

from tests.architecture import prose
from tests.support.sources import ALL_PACKAGES, ROOT, Source, sources

PAGES = [*(ROOT / "docs").rglob("*.md")]
DOCUMENTS = [*ROOT.glob("*.md"), *PAGES]


def test_module_docstrings_do_not_open_with_a_question_word():
    assert [fault for source in sources(*ALL_PACKAGES) for fault in prose.question_for_a_docstring(source)] == []


def test_code_names_the_actor():
    assert [fault for source in sources(*ALL_PACKAGES) for fault in prose.dialect(source.path, source.text)] == []


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda file: file.relative_to(ROOT).as_posix())
def test_documents_name_the_actor(document):
    assert prose.dialect(document.name, document.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize("page", PAGES, ids=lambda file: file.relative_to(ROOT).as_posix())
def test_pages_name_the_thing(page):
    assert prose.stilted(page.name, page.read_text(encoding="utf-8")) == []


def test_rules_find_violations():
    assert prose.question_for_a_docstring(Source.of("a.py", '"""What an agent is told at its start."""'))
    assert prose.question_for_a_docstring(Source.of("a.py", '"""Settings of an agent."""')) == []
    assert prose.dialect("a.md", "one\nWhoever asks, waits.") == ["a.md:2: Whoever"]
    assert prose.dialect("a.md", "The client waits.") == []
    assert prose.stilted("a.md", "```\nthose of\n```\nThe frame is that of the robot.") == ["a.md:4: that of"]
    assert prose.stilted("a.md", "`types are those of ROS 2` is printed in that office.") == []
