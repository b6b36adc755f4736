"""The sidebar has the sections of the site, and each page once."""

from docs.site.build import HERE
from docs.site.navigation import Section, read_navigation, sidebar
from docs.site.pages import GENERATED, HOME, project_pages

SECTIONS = ("Start", "Robots", "Maps and planning", "Fleet", "Bridges", "Operate", "Reference", "Internals")


def test_sections_are_in_the_order_of_a_reader() -> None:
    assert tuple(section.title for section in read_navigation(HERE / "navigation.toml")) == SECTIONS


def test_each_page_is_in_one_section() -> None:
    named = [page for section in read_navigation(HERE / "navigation.toml") for page in section.pages]
    decisions = {place for place in project_pages().values() if place.startswith("adr/0")}
    assert len(named) == len(set(named))
    assert set(named) == {*project_pages().values(), *GENERATED} - decisions - {HOME}, "name it in navigation.toml"


def test_a_section_is_a_table_of_contents_that_the_page_does_not_show() -> None:
    tree = sidebar([Section("Start", ("quickstart", "dashboard"))])
    assert tree == "\n```{toctree}\n:hidden:\n:caption: Start\n\nquickstart\ndashboard\n```\n"
