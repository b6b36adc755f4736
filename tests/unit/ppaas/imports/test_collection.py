"""Garbage collection while a file is imported: off, and then as it was."""

import gc

import pytest

from ppaas.errors import InvalidInput
from ppaas.imports.collection import uncollected
from ppaas.imports.graphs.reading import import_graph


def test_collection_is_off_within_and_on_afterwards() -> None:
    with uncollected():
        assert not gc.isenabled()
        with uncollected():
            pass
        assert not gc.isenabled()
    assert gc.isenabled()


def test_collection_is_on_after_a_file_that_is_refused() -> None:
    with pytest.raises(InvalidInput):
        import_graph(b"", "empty.json")
    assert gc.isenabled()
