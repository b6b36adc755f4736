"""Chains: the parts of a network of lanes between its ends and junctions."""

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

from ppaas.fleet.lanes.drawing import Network


class Chain(NamedTuple):
    """Places one after the other, of which only the first and the last may be ends or junctions.

    Parameters
    ----------
    places : tuple of int
        Of a ring, the last is the first.
    name : str
        Name of the lane, of one of its first part if there are several.
    forth, back : bool
        Whether robots may drive along it, and the other way.
    """

    places: tuple[int, ...]
    name: str
    forth: bool
    back: bool


def chains_of(network: Network) -> list[Chain]:
    """Return the chains of a network; each part is in one of them."""
    near = network.near()
    keys = [place for place in near if _is_key(network, place, near[place])]
    left = {(min(part), max(part)) for part in network.names}
    found = []
    for start in [*keys, *near]:  # what is left after the key places are rings
        for other in near[start]:
            if (min(start, other), max(start, other)) in left:
                places = tuple(_walk(near, {start, *keys}, start, other))
                left -= {(min(part), max(part)) for part in pairwise(places)}
                found.append(_chain(network, places))
    return found


def _is_key(network: Network, place: int, near: list[int]) -> bool:
    """Return whether a place is an end, a junction, or where a lane becomes one-way."""
    if len(near) != 2:
        return True
    before, behind = near
    return _ways(network, before, place) != _ways(network, place, behind)


def _ways(network: Network, one: int, other: int) -> tuple[bool, bool]:
    return (one, other) in network.names, (other, one) in network.names


def _walk(near: dict[int, list[int]], ends: set[int], start: int, onward: int) -> Iterator[int]:
    before, here = start, onward
    yield start
    while here not in ends:
        yield here
        before, here = here, next(other for other in near[here] if other != before)
    yield here


def _chain(network: Network, places: tuple[int, ...]) -> Chain:
    one, other = places[:2]
    forth, back = _ways(network, one, other)
    name = network.names[one, other] if forth else network.names[other, one]
    return Chain(places, name, forth, back)
