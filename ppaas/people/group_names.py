"""Names of what belongs to a group: the robots of one user on one map that track people."""

import hashlib


def coordinator_checkpoint(map_id: str) -> str:
    """Return the name of a coordinator's checkpoints among its user's, made of the id of its map."""
    return f"people-{hashlib.blake2b(map_id.encode(), digest_size=16).hexdigest()}"
