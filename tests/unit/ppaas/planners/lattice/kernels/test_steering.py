from hypothesis import given

from ppaas.planners.lattice.kernels.dubins import dubins
from ppaas.planners.lattice.kernels.reeds_shepp import reeds_shepp
from ppaas.planners.lattice.kernels.steering import Car, curve
from tests.unit.ppaas.planners.lattice.kernels.test_reeds_shepp import (
    GOALS,
    WEIGHTS,
    pieces_of,
    weighed,
)


@given(GOALS, WEIGHTS, WEIGHTS)
def test_curve_is_the_cheapest_word_not_the_shortest(goal, reverse, turn):
    car = Car(1.0, True, 72, reverse, turn, 0.0, 3.5, 9.0)
    cost = curve(car, 0.0, 0.0, 0.0, *goal).cost
    assert cost <= weighed(pieces_of(reeds_shepp(*goal, 1.0, 1.0)), reverse, turn) + 1e-9
    assert cost <= weighed(pieces_of(dubins(*goal, turn)), reverse, turn) + 1e-9
