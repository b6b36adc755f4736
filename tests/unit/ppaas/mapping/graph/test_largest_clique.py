import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ppaas.mapping.graph import consistency as module
from ppaas.mapping.graph.consistency import largest_clique
from tests.reference.mapping import pose_graph as twin


def random_graph(count, share, seed):
    upper = np.triu(np.random.default_rng(seed).random((count, count)) < share, 1)
    return upper | upper.T


@given(st.integers(0, 14), st.floats(0.0, 1.0), st.integers(0, 1000))
def test_clique_is_connected_and_as_large_as_the_twins(count, share, seed):
    connected = random_graph(count, share, seed)
    found = largest_clique(connected)
    assert len(found) == twin.largest_clique_size(connected)
    assert connected[np.ix_(found, found)].sum() == len(found) * (len(found) - 1)
    assert (np.diff(found) > 0).all()


def test_search_ends_after_its_limit(monkeypatch):
    monkeypatch.setattr(module, "_EXPANSIONS", 50)
    connected = random_graph(200, 0.7, 0)
    found = largest_clique(connected)
    assert len(found) > 5
    assert connected[np.ix_(found, found)].sum() == len(found) * (len(found) - 1)
