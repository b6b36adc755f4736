"""Rows of plans in Cassandra."""

from storage.cassandra.plans.rows import head_parts, location_cell, plan_rows
from tests.support.storage.records import plan


def test_a_location_has_the_cell_of_a_plan_and_differs_between_plans() -> None:
    one, other = plan_rows([plan("p"), plan("p", cost=1.0)], 8)
    assert location_cell(one.location) == one.cell == location_cell(other.location)
    assert one.location != other.location
    assert head_parts(one.head) == (one.context, one.entry.body)
