"""Names of groups, and of robots' nodes for people: a node exists if a robot's file has parameters for it."""

import hashlib
from collections.abc import Mapping
from typing import Any

TORSO_DETECTOR, LEG_DETECTOR = "torso_detector", "leg_detector"
PEOPLE_TRACKER, FOLLOW_PERSON = "people_tracker", "follow_person"
PEOPLE_COORDINATOR = "people_coordinator"
"""The node of a group of robots, in a separate container."""

FOLLOWING_GOAL = f"{FOLLOW_PERSON}/"
"""Beginning of the ids of the goals for Move Base that the node ``follow_person`` sends."""

_OF_TRACKERS = (TORSO_DETECTOR, LEG_DETECTOR, PEOPLE_TRACKER)


def tracks_people(parameters: Mapping[str, Any]) -> bool:
    """Return whether a robot has ``people_tracker``: with a detector, or by its own parameters."""
    return any(name in parameters for name in _OF_TRACKERS)


def hears_coordinator(parameters: Mapping[str, Any]) -> bool:
    """Return whether a robot's clone receives the state of its people coordinator: if it has a node for people."""
    return tracks_people(parameters) or FOLLOW_PERSON in parameters


def coordinator_checkpoint(map_id: str) -> str:
    """Return the name of a coordinator's checkpoints among its user's, made of the id of its map."""
    return f"people-{hashlib.blake2b(map_id.encode(), digest_size=16).hexdigest()}"
