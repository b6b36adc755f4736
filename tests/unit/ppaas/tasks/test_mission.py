"""Mission files: tasks by name at places by name; what is wrong is refused with its place."""

import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from ppaas.errors import InvalidInput
from ppaas.tasks.mission import mission_in, schema, tasks_of
from ppaas.tasks.options import PlaceHold

EXAMPLE = Path("docs/examples/missions/morning.json")
GO: dict[str, Any] = {"name": "a", "kind": "go_to", "at": [[1, 2]]}


def file_of(*tasks: dict[str, Any], **fields: Any) -> bytes:
    return json.dumps({"map": "house", "tasks": [GO | task for task in tasks]} | fields).encode()


def test_tasks_have_places_by_name_and_times_after_the_start() -> None:
    fields = {"holds": [{"confirm": True}, None], "start": 5.0, "deadline": 60.0, "robot": "tb1", "weight": 2.0}
    content = file_of({"kind": "pick_drop", "at": ["shelf", "kitchen"]} | fields, places={"shelf": [3, 4]})
    [task] = tasks_of(mission_in(content), {"kitchen": (5.0, 6.0, 1.5), "shelf": (0.0, 0.0)}, 1000.0)
    assert (task.id, task.created, task.named_robot, task.weight) == ("a", 1000.0, "tb1", 2.0)
    assert task.places == ((3.0, 4.0, 0.0), (5.0, 6.0, 1.5))
    assert (task.not_before, task.deadline) == (1005.0, 1060.0)
    assert task.hold is not None and task.hold.confirm and isinstance(task.hold, PlaceHold)


def test_tasks_come_after_those_that_they_wait_for() -> None:
    tasks = tasks_of(
        mission_in(file_of({"after": [{"task": "b"}]}, {"name": "b", "after": [{"task": "c"}]}, {"name": "c"})), {}, 0.0
    )
    assert [task.id for task in tasks] == ["c", "b", "a"]


def test_places_have_floors_of_their_own_or_by_their_names() -> None:
    at = ["shelf", {"floor": "L2", "at": "desk"}, {"floor": "L3", "at": [7, 8]}, [1, 2]]
    places = {"shelf": {"floor": "L2", "at": [3, 4, 0.5]}}
    mission = mission_in(file_of({"kind": "patrol", "at": at}, {"name": "b"}, places=places))
    assert mission.floors == ["L2", "L3"]
    over, plain = tasks_of(mission, {}, 0.0, home="L1", others={"L2": {"desk": (5.0, 6.0)}, "L3": {}})
    assert over.places == ((3.0, 4.0, 0.5), (5.0, 6.0, 0.0), (7.0, 8.0, 0.0), (1.0, 2.0, 0.0))
    assert (over.floors, plain.floors, plain.home) == (("L2", "L2", "L3", "L1"), (), "L1")
    with pytest.raises(InvalidInput, match=r"there is no place 'desk': floor 'L2' has no stations"):
        tasks_of(mission, {}, 0.0, home="L1")


@pytest.mark.parametrize(
    ("content", "advice"),
    [
        (b"[", "not JSON"),
        (b"[]", "malformed"),
        (file_of(), "tasks"),
        (file_of({}, {}), "'a'"),
        (file_of({"speed": 1}), "speed"),
        (file_of({"holds": [{"confirm": True, "second": 3}]}), "second"),
        (file_of({"kind": "fly"}), "kind"),
        (file_of({"at": ["kitchn"]}), "'kitchen'"),
        (file_of({"at": [[1]]}), "at"),
        (file_of({"at": [[1, 2], [3, 4]]}), "'a'"),
        (file_of({"name": "a b"}), "name"),
        (file_of({"after": [{"task": "z"}]}), "'z'"),
        (file_of({"after": [{"task": "b"}]}, {"name": "b", "after": [{"task": "a"}]}), "each other"),
        (file_of({"repeat": {"every": 0.1}}), "every"),
        (file_of({"start": -1e13}), "not_before"),
        (file_of({"at": [{"floor": "", "at": [1, 2]}]}), "floor"),
        (file_of({"at": [{"floor": "L2", "x": 1}]}), "at"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_refused_with_its_place(content: bytes, advice: str) -> None:
    with pytest.raises(InvalidInput, match=advice):
        tasks_of(mission_in(content), {"kitchen": (1.0, 2.0)}, 0.0)


def test_the_published_schema_is_the_one_of_the_code_and_fits_the_example() -> None:
    published = json.loads(Path("docs/examples/missions/schema.json").read_text())
    assert published == schema(), "write it again: ppaas task schema > docs/examples/missions/schema.json"
    jsonschema.validate(json.loads(EXAMPLE.read_text()), published)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({"map": "house", "tasks": [GO | {"kind": "fly"}]}, published)
    assert len(tasks_of(mission_in(EXAMPLE.read_bytes()), {}, 0.0)) == 4
