"""A place without sockets, and two clients at it."""

from tests.support.endpoints.still_place_fixtures import client, other, place

__all__ = ["client", "other", "place"]
