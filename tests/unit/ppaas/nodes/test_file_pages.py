"""Pages of a file."""

import base64

import pytest

from ppaas.errors import InvalidInput
from ppaas.nodes import file_pages
from ppaas.nodes.file_pages import FilePages


def test_pages_join_to_the_file_which_is_forgotten_after_its_end(monkeypatch):
    monkeypatch.setattr(file_pages, "PAGE", 4)
    pages = FilePages("map")
    pages.use(b"0123456789")
    got = [pages.page(offset) for offset in (0, 4, 8, 10)]
    assert [base64.b64decode(text) for text, _ in got] == [b"0123", b"4567", b"89", b""]
    assert {size for _, size in got} == {10}
    with pytest.raises(InvalidInput, match="the file of the map has 0 bytes, not 4: begin at 0"):
        pages.page(4)


@pytest.mark.parametrize("offset", [-1, 11])
def test_an_offset_outside_the_file_is_refused(offset):
    pages = FilePages("map")
    pages.use(b"0123456789")
    with pytest.raises(InvalidInput, match=f"has 10 bytes, not {offset}"):
        pages.page(offset)
