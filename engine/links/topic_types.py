"""Check of the types by which clients name topics."""

from ppaas.errors import Conflict


def check_type(topic: str, has: str, wanted: str) -> None:
    """Check that a topic has the type that a client expects.

    Raises
    ------
    Conflict
        It has another type.
    """
    if has != wanted:
        raise Conflict(f"topic {topic!r} has type {has}, not {wanted}")
