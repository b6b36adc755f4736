import numpy as np

from benchmarks.people.torso.fitting import BoostingParameters, boost

SMALL = BoostingParameters(trees=30, rate=0.5, drawn=0.8)


def test_trees_learn_a_rule_of_two_features() -> None:
    rng = np.random.default_rng(0)
    values = rng.integers(0, 32, (2000, 6)).astype(np.uint8)
    labels = ((values[:, 1] > 12) & (values[:, 4] <= 20)).astype(float)
    odds = boost(values[:1000], labels[:1000], SMALL).odds(values[1000:])
    assert ((odds > 0.0) == (labels[1000:] > 0.0)).mean() > 0.97


def test_labels_without_a_rule_give_their_mean() -> None:
    values = np.zeros((400, 3), np.uint8)
    labels = np.tile([1.0, 0.0, 0.0, 0.0], 100)
    odds = boost(values, labels, SMALL).odds(values[:1])
    assert abs(odds[0] + np.log(3.0)) < 0.2
