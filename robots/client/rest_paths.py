"""Paths of the REST service."""

from urllib.parse import quote


def path_of(*parts: str) -> str:
    """Return the path of a resource, such as ``/v1/maps/office``. The cloud, not this function, checks the names."""
    return "/v1/" + "/".join(quote(part, safe="", errors="surrogateescape") for part in parts)
