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
