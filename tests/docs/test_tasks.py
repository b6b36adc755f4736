"""Fields, states and numbers of tasks.md are those of the code."""

import re
from typing import get_args

from endpoints.rest.tasks import tasks
from endpoints.rest.tasks.schemas import TaskFile
from engine.service.tasks import retention, ways
from ppaas.tasks import assignment, dispatcher, records
from tests.support.documents import table, text_of

PAGE = "docs/tasks.md"


def test_fields_and_states_are_those_of_the_code() -> None:
    fields = dict(table(PAGE, "field", "meaning"))
    assert set(fields) == set(TaskFile.model_fields)
    assert f"up to {records.MOST_PLACES} places" in fields["kind"]
    assert f"up to {records.MOST_ROUNDS};" in fields["rounds"]
    assert f"−{records.MOST_PRIORITY} to {records.MOST_PRIORITY};" in fields["priority"]
    assert set(dict(table(PAGE, "state", "meaning"))) == set(get_args(records.TaskState))


def test_numbers_are_those_of_the_code() -> None:
    text = re.sub(r"\s+", " ", text_of(PAGE))
    for said in (
        f"You may have {tasks.MOST_OPEN} tasks",
        f"kept for {retention.KEPT_FOR / 86400:g} days, at most the last {retention.MOST_ENDED}",
        f"does not answer within {ways.TIMEOUT:g} s",
        f"by a speed of {assignment.SPEED:g} m/s",
        f"worth {assignment.PRIORITY:g} s of driving. A task that has waited for {assignment.PRIORITY:g} s",
        f"in the {assignment.URGENT:g} s before its deadline",
        f"saves {assignment.MARGIN:g} s of driving",
        f"no task for {dispatcher.REST:g} s",
        f"not connected for {dispatcher.GONE_AFTER:g} s",
        f"After {dispatcher.MOST_FAILURES} failures",
    ):
        assert said in text, said
