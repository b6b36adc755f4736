"""Records to put into stores."""

from typing import Any

import numpy as np

from storage.records import CloneCheckpoint, MapRecord, PlanRecord, RobotRecord, Token, User
from storage.versions import new_map

NOT_NAMES = ["", ".", "..", "../x", "/etc", "a/b", "a\n", "a b", "-a", "_a", "ä", "a\0", "x" * 65, "\ud800"]

YAML = b"""image: house.pgm
resolution: 0.05
origin: [-1.0, -2.0, 0.0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
"""


def pgm(width: int = 4, height: int = 3, value: int = 254) -> bytes:
    """Return a binary PGM of one shade."""
    return b"P5\n%d %d\n255\n" % (width, height) + bytes([value]) * (width * height)


def user(user_id: str = "ann", **fields: Any) -> User:
    return User(user_id, **({"password_hash": "$argon2id$…"} | fields))


def token(token_hash: str = "a" * 64, **fields: Any) -> Token:
    return Token(token_hash, **({"user": "ann", "expires": 1000.0} | fields))


def robot(robot_id: str = "tb1", **fields: Any) -> RobotRecord:
    return RobotRecord(robot_id, **({"user": "ann", "map": "house"} | fields))


def plan(plan_id: str = "p1", **fields: Any) -> PlanRecord:
    poses = np.arange(14, dtype="<f8").tobytes()
    given = {"user": "ann", "map": "house", "version": "v", "planner": "dijkstra", "start": (0.0, 0.0, 0.0)}
    found = {"goal": (1.0, 2.0, 0.5), "length": 2.25, "cost": 118.5, "seconds": 0.004, "poses": poses, "created": 5.0}
    return PlanRecord(plan_id, **(given | found | fields))


def clone(robot_id: str = "tb1", **fields: Any) -> CloneCheckpoint:
    return CloneCheckpoint(
        **({"user": "ann", "robot": robot_id, "nodes": {"amcl": b"\x00\xff"}, "saved": 7.0} | fields)
    )


def house(map_id: str = "house", owner: str = "ann", image: bytes = pgm(), **fields: Any) -> MapRecord:
    return new_map(map_id, owner, YAML, image, **({"created": 3.0} | fields))
