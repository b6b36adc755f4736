"""Identifiers of orders and nodes: made from the id of a path, so that a restarted bridge knows its orders again."""

import re
from hashlib import blake2b

_KEY = re.compile(r"(?P<key>[0-9a-f]{16})(-(?P<index>\d{1,6}))?")


def key_of(path: str) -> str:
    """Return the key of a path: 16 hexadecimal digits."""
    return blake2b(path.encode(), digest_size=8).hexdigest()


def node_id(key: str, index: int) -> str:
    """Return the id of the node at a corner of the route of a path."""
    return f"{key}-{index}"


def index_of(key: str, node: str) -> int | None:
    """Return the corner of a node of a path; None for a node of another path."""
    found = _KEY.fullmatch(node)
    return int(found["index"]) if found and found["index"] and found["key"] == key else None


def is_ours(order: str, nodes: list[str]) -> bool:
    """Return whether an order and its nodes have identifiers as this module makes them."""
    return bool(_KEY.fullmatch(order)) and all(_KEY.fullmatch(node) for node in nodes)
