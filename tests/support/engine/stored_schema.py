"""Schema of what one release stores and another one reads: checkpoints of clones and groups, and records of stores.

``python -m tests.support.engine.stored_schema`` writes the schema of the newest protocol, and a sample of each.
"""

from collections.abc import Iterator
from typing import Any

import msgspec

from engine.container.monitor.node import MonitorState
from engine.control.journeys.kept import KeptJourneys
from engine.protocols.versions import OWN
from engine.sessions.host import SessionRecord
from engine.specs.checkpoints import CheckpointOrigin
from engine.specs.robot_stops import StoredStops
from ppaas.decoding import from_json, from_msgpack
from ppaas.messages.health.stops import RobotStop
from ppaas.nodes.amcl.node import AmclState
from ppaas.nodes.depth_images import DepthLens
from ppaas.nodes.docking_server.goals import DockingState
from ppaas.nodes.explore.goals import Exploration
from ppaas.nodes.follow_person.node import FollowPersonState
from ppaas.nodes.footprint.node import FootprintState
from ppaas.nodes.grid_slam.logbook import Head, Located
from ppaas.nodes.move_base.node import MoveBaseState
from ppaas.nodes.people_tracker.node import PeopleTrackerState
from ppaas.nodes.recorder.node import RunningRecording
from ppaas.nodes.tf.republisher import TfRepublisherState
from ppaas.nodes.waypoint_follower.node import WaypointFollowerState
from ppaas.people.coordinator.state import SavedCoordinator
from ppaas.perception.depth_scan import PinholeCamera
from ppaas.traffic.coordinator import TrafficCheckpoint
from ppaas.transforms.spatial import Rigid
from storage.backup.manifest import BackupManifest
from storage.backup.reading import RECORDS
from storage.records import Lease
from tests.support.engine.wire_schema import FOLDER, Schema, breaks_of_types, encoded, of_error, plain, sample

NODES: dict[str, Any] = {
    "amcl": AmclState,
    "depthimage_to_laserscan": PinholeCamera,
    "docking_server": DockingState,
    "footprint": FootprintState,
    "explore": tuple[Exploration | None, int],
    "follow_person": FollowPersonState,
    "grid_slam": Head | Located,
    "move_base": MoveBaseState,
    "node_monitor": MonitorState,
    "octomap_server": DepthLens,
    "parameter_server": dict[str, Any],
    "people_coordinator": SavedCoordinator,
    "people_tracker": PeopleTrackerState,
    "recorder": RunningRecording,
    "robot_state_publisher": list[tuple[str, str, Rigid]],
    "stop": tuple[RobotStop, ...],
    "tf2_web_republisher": TfRepublisherState,
    "torso_detector": DepthLens,
    "traffic": TrafficCheckpoint,
    "waypoint_follower": WaypointFollowerState,
}
"""Checkpoints of nodes, by the name of the node."""

STORED: dict[str, Any] = {
    **{f"checkpoint of {name}": kind for name, kind in NODES.items()},
    "checkpoint: origin": CheckpointOrigin,
    "checkpoint: sessions of clients": list[SessionRecord],
    "checkpoint: stops of a user": StoredStops,
    "checkpoint: journeys in a building": KeptJourneys,
    **{f"record: {name}": kind for name, kind in RECORDS.items()},
    "record: leases": Lease,
    "backup": BackupManifest,
}
"""Everything that is stored."""

PACKED = (
    "checkpoint of people_coordinator", "checkpoint of traffic", "checkpoint: stops of a user",
    "checkpoint: journeys in a building",
)  # fmt: skip
"""Checkpoints that are MessagePack, as all records are; others are JSON."""


def stored_schema() -> Schema:
    """Return the schema: what is stored by name, and the fields of all types."""
    shown, parts = msgspec.json.schema_components(STORED.values(), schema_hook=of_error, ref_template="{name}")
    return {
        "stored": {name: plain(part) for name, part in zip(STORED, shown, strict=True)},
        "types": {name: plain(part) for name, part in sorted(parts.items())},
    }


def breaks_of_stored(before: Schema, after: Schema) -> Iterator[str]:
    """Yield the changes that keep one release from reading what the other one has stored."""
    for name, had in before["stored"].items():
        has = after["stored"].get(name)
        if has is None:
            yield f"{name} was removed"
        elif has != had:
            yield f"{name} is of another type"
    yield from breaks_of_types(before["types"], after["types"])


def stored_samples() -> dict[str, str]:
    """Return a sample of everything that is stored, as it is stored, in hexadecimal."""
    found = {}
    for name, kind in STORED.items():
        encode = msgspec.msgpack.encode if is_packed(name) else msgspec.json.encode
        found[name] = encode(sample(kind)).hex()
    return found


def read_stored(name: str, data: bytes) -> Any:
    """Return what was stored; raises the errors of decoding."""
    return (from_msgpack if is_packed(name) else from_json)(data, STORED[name])


def as_stored(name: str) -> Any:
    """Return a sample as a schema checks it: the fields that are stored, in the types of JSON."""
    return msgspec.json.decode(msgspec.json.encode(sample(STORED[name])))


def is_packed(name: str) -> bool:
    """Return whether it is stored as MessagePack."""
    return name in PACKED or not name.startswith("checkpoint")


def document(schema: Schema, name: str) -> Schema:
    """Return a schema of JSON for what is stored under a name."""
    return {**_referring(schema["stored"][name]), "types": _referring(schema["types"])}


def _referring(part: Any) -> Any:
    if isinstance(part, dict):
        return {
            key: f"#/types/{value}" if key == "$ref" and isinstance(value, str) else _referring(value)
            for key, value in part.items()
        }
    return [_referring(one) for one in part] if isinstance(part, list) else part


if __name__ == "__main__":
    (FOLDER / f"stored-{OWN.newest}.json").write_text(encoded(stored_schema()))
    (FOLDER / f"stored-samples-{OWN.newest}.json").write_text(encoded({"samples": stored_samples()}))
