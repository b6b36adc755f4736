"""Markdown of the reference is what its readers take for tables and anchors."""

import pytest

from docs.site.reference.markdown import cell, page, slug, table


def test_a_cell_is_one_line_and_keeps_its_bars() -> None:
    assert cell("a | b\n  c \\| d") == "a \\| b c \\| d"


def test_a_table_has_a_header_and_is_left_out_if_it_has_no_rows() -> None:
    assert table(("a", "b"), [("1", "2")]) == "| a | b |\n|---|---|\n| 1 | 2 |\n"
    assert table(("a", "b"), []) == ""


@pytest.mark.parametrize(
    ("heading", "anchor"),
    [
        ("`ppaas map publish`", "ppaas-map-publish"),
        ("`nav_msgs/Path`", "nav_msgspath"),
        ("3D maps", "3d-maps"),
    ],
)
def test_an_anchor_is_that_of_its_heading(heading: str, anchor: str) -> None:
    assert slug(heading) == anchor


def test_a_page_has_an_empty_line_between_its_parts() -> None:
    assert page("# A", "", "text\n") == "# A\n\ntext\n"
