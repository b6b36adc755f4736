"""Groups of writes of plans, without a Cassandra."""

import itertools

import numpy as np
import pytest

from storage.cassandra.connection.session import MAX_BATCH_BYTES, MAX_BATCH_ROWS
from storage.cassandra.plans.endpoint_cells import cell_key
from storage.cassandra.plans.rows import plan_rows
from storage.cassandra.plans.writes import insert_names, insert_plans
from storage.records import PlanRecord
from tests.support.storage.records import plan


def from_place(number: int, metres: float) -> PlanRecord:
    poses = np.zeros((2, 7))
    poses[:, 0] = metres
    return plan(f"p{number}", poses=poses.tobytes())


def test_interleaved_plans_of_one_bucket_are_sent_together() -> None:
    records = [from_place(number, 10.0 * (number % 4)) for number in range(80)]
    groups = list(insert_plans(list(plan_rows(records, 8))))
    leading = [values[0] for group in groups for _, values in group]
    assert len(leading) == 80
    assert len(list(itertools.groupby(leading))) == len({cell_key(record)[0] for record in records}) == 4


@pytest.mark.parametrize("places", [1, 3, 50])
def test_batches_stay_within_the_limits_of_cassandra(places: int) -> None:
    rows = list(plan_rows([from_place(number, 10.0 * (number % places)) for number in range(50)], 8))
    for groups in (list(insert_plans(rows)), list(insert_names(rows))):
        assert all(len({(cql, values[0]) for cql, values in group}) <= MAX_BATCH_ROWS for group in groups)
        sizes = [
            sum(len(value) for _, values in each for value in values if isinstance(value, bytes)) for each in groups
        ]
        assert max(sizes) <= MAX_BATCH_BYTES
    ids = [row.record.id for row in rows]
    assert sorted(values[2] for group in insert_plans(rows) for _, values in group) == sorted(ids)
    assert sorted(values[-1] for group in insert_names(rows) for cql, values in group if "by_map" in cql) == sorted(ids)
    assert [values for group in insert_names(rows) for cql, values in group if "INTO plans " in cql] == [
        (row.record.id, row.location) for row in rows
    ]
