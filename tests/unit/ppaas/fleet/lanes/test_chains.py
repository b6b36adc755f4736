"""Chains of a network of lanes: each part is in one, and only their ends are ends or junctions."""

from itertools import pairwise

from ppaas.fleet.lane_drawing import network_of
from ppaas.fleet.lane_placing import chains_of
from tests.support.fleet.lanes import SITE, line, ring


def test_each_part_is_in_one_chain() -> None:
    network = network_of(SITE)
    parts = [frozenset(part) for chain in chains_of(network) for part in pairwise(chain.places)]
    assert len(parts) == len(set(parts))
    assert set(parts) == {frozenset(part) for part in network.names}


def test_chains_end_at_ends_and_junctions_only() -> None:
    network = network_of(SITE)
    near = network.near()
    for chain in chains_of(network):
        assert all(len(near[place]) == 2 for place in chain.places[1:-1])
        assert all(len(near[place]) != 2 for place in (chain.places[0], chain.places[-1]))


def test_a_ring_is_one_chain() -> None:
    (chain,) = chains_of(network_of([ring(5, 5, 2)]))
    assert chain.places[0] == chain.places[-1]
    assert (chain.forth, chain.back) == (True, True)


def test_a_chain_ends_where_a_lane_becomes_one_way() -> None:
    network = network_of([line((0, 0), (3, 0)), line((3, 0), (6, 0), name="on", one_way=True)])
    found = {(chain.name, chain.forth, chain.back) for chain in chains_of(network)}
    assert ("(0, 0)", True, True) in found
    assert found - {("(0, 0)", True, True)} in ({("on", True, False)}, {("on", False, True)})
