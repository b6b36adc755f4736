"""What is sent to Cassandra of plans, as no Cassandra is needed to see."""

import itertools

import numpy as np

from storage.cassandra_plan_rows import led, plan_rows
from storage.cassandra_plans import _together
from storage.cassandra_session import BYTES_TOGETHER
from storage.records import PlanRecord
from tests.support.records import plan


def from_place(number: int, metres: float) -> PlanRecord:
    poses = np.zeros((2, 7))
    poses[:, 0] = metres
    return plan(f"p{number}", poses=poses.tobytes())


def test_plans_of_one_bucket_are_sent_together_though_others_come_between() -> None:
    records = [from_place(number, 10.0 * (number % 4)) for number in range(80)]
    groups = list(_together(list(plan_rows(records, 8))))
    leading = [values[0] for group in groups for cql, values in group if "plans_by_ends" in cql]
    assert len(leading) == 80
    assert len(list(itertools.groupby(leading))) == len({led(record)[0] for record in records}) == 4


def test_all_that_keeps_a_plan_is_in_one_group_and_no_group_is_large() -> None:
    records = [from_place(number, 10.0 * (number % 3)) for number in range(50)]
    groups = list(_together(list(plan_rows(records, 8))))
    told = [[value for _, values in group for value in values if isinstance(value, str)] for group in groups]
    kept = [{name for name in names if name != "house"} for names in told]
    assert sum(map(len, kept)) == len(set().union(*kept)) == 50
    assert all(len(group) == 3 * len(names) for group, names in zip(groups, kept, strict=True))
    sizes = [sum(len(value) for _, values in group for value in values if isinstance(value, bytes)) for group in groups]
    assert max(sizes) <= BYTES_TOGETHER
