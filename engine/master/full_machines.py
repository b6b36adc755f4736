"""Sizes that no machine has room for, so that one decision does not ask the balancer for the same again and again."""

import math

from engine.master.places import Place, PlaceRequest


class FullMachines:
    """Smallest size that no machine had room for, by required labels; valid until room becomes free."""

    def __init__(self) -> None:
        self._sizes: dict[frozenset[tuple[str, str]], float] = {}

    def note(self, wanted: Place | PlaceRequest) -> None:
        """Note that no machine has room for a container of a place or request."""
        self._sizes[_labels(wanted)] = wanted.cores

    def refuse(self, wanted: Place | PlaceRequest) -> bool:
        """Return whether no machine has room, because a container no larger found none among the same machines."""
        return bool(self._sizes) and wanted.cores >= self._sizes.get(_labels(wanted), math.inf)


def _labels(wanted: Place | PlaceRequest) -> frozenset[tuple[str, str]]:
    request = wanted.request if isinstance(wanted, Place) else wanted
    return frozenset(request.labels.items())
