"""Records for tests of stores."""

import hashlib
from typing import Any

import msgspec
import numpy as np

from ppaas.buildings.building import Building, Floor
from storage.buildings.records import BuildingRecord, BuildingVersion
from storage.memory.maps import MemoryMapStore
from storage.ports import MapStore
from storage.records import (
    CloneCheckpoint,
    ConfirmedPlaces,
    MapFile,
    MapRecord,
    MapReview,
    PlanRecord,
    ProposedChange,
    Publication,
    RobotRecord,
    Token,
    User,
)
from storage.versions import PARTS, map_version

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


def building(
    building_id: str = "hq", owner: str = "ann", readers: tuple[str, ...] = (), versions: int = 1
) -> BuildingRecord:
    """Return a building in a number of versions, of which each has a floor more than the one before."""

    def made(number: int) -> BuildingVersion:
        floors = tuple(Floor(name=f"L{level}", map=f"hq-{level}", elevation=3.5 * level) for level in range(number))
        return BuildingVersion(
            number=number, building=Building(floors=floors), author=owner, created=float(number), message="é"
        )

    record = BuildingRecord(user=owner, id=building_id, present=made(1), readers=readers)
    for number in range(2, versions + 1):
        record = record.followed_by(made(number))
    return record


class GivenMap(msgspec.Struct, frozen=True):
    """A map to publish; a file that is None is missing."""

    id: str
    owner: str
    yaml: bytes | None
    image: bytes | None
    octomap: bytes | None = None
    posegraph: bytes | None = None
    zones: bytes | None = None
    readers: tuple[str, ...] = ()
    created: float = 3.0
    description: str = ""

    @property
    def files(self) -> dict[str, bytes]:
        return {part: data for part in PARTS if (data := getattr(self, part)) is not None}

    @property
    def version(self) -> str:
        files = self.files.items()
        return map_version({part: MapFile(hashlib.sha256(data).hexdigest(), len(data)) for part, data in files})

    def readable_by(self, user: str) -> bool:
        return user == self.owner or user in self.readers or "*" in self.readers


def house(map_id: str = "house", owner: str = "ann", image: bytes | None = pgm(), **fields: Any) -> GivenMap:
    return GivenMap(map_id, owner, **({"yaml": None if image is None else YAML, "image": image} | fields))


def put_map(store: MapStore, given: GivenMap, keeps: frozenset[str] = frozenset(), **said: Any) -> MapRecord:
    """Publish a map with all its metadata; keyword arguments replace fields of the publication."""
    told = {"readers": tuple(given.readers), "description": given.description, "author": given.owner} | said
    with store.stage() as upload:
        for part, data in given.files.items():
            upload.add(part, [data])
        upload.keeps = keeps
        return store.publish(upload, Publication(given.id, created=given.created, owner=given.owner, **told))


def propose(
    store: MapStore,
    given: GivenMap,
    base: str | None = None,
    keeps: frozenset[str] = frozenset(),
    change: ProposedChange | None = None,
    **said: Any,
) -> MapReview:
    """Propose a version of a map, made from its current version by default."""
    told = {"author": given.owner, "created": given.created, "owner": given.owner} | said
    places = ConfirmedPlaces("tb1", left=((1.25, -0.5),))
    change = change or ProposedChange(occupied=3, rectangles=((0, 1, 2, 3),), confirmed=places)
    with store.stage() as upload:
        for part, data in given.files.items():
            upload.add(part, [data])
        upload.keeps = keeps
        return store.propose(
            upload, Publication(given.id, **told), base=base or store.map_head(given.id).version, change=change
        )


def found_map(store: MapStore, map_id: str = "house", version: str | None = None) -> GivenMap:
    """Read a map back from a store."""
    with store.open_map(map_id, version) as opened:
        files = {part: bytes(opened.buffers[part]) if part in opened.buffers else None for part in PARTS}
        record = opened.record
        said = {"readers": record.readers, "created": record.created, "description": record.description}
        return GivenMap(record.id, record.owner, **files, **said)


def kept(given: GivenMap) -> MemoryMapStore:
    """Return a store in memory that has one map."""
    store = MemoryMapStore()
    put_map(store, given)
    return store
