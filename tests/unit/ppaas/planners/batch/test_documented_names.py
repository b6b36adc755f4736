"""Documented import paths keep working."""

from ppaas.planners import cost_matrix as documented_cost_matrix
from ppaas.planners import many
from ppaas.planners.batch.cost_matrix import cost_matrix
from ppaas.planners.batch.plan_many import plan_many


def test_batch_functions_have_their_documented_import_paths() -> None:
    assert many.plan_many is plan_many
    assert documented_cost_matrix.cost_matrix is cost_matrix
