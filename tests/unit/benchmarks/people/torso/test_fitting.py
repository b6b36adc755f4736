"""Fits of the torso detector: boosted trees, and templates."""

import numpy as np
import pytest

from benchmarks.people.torso.fitting import BoostingParameters, Fitted, Samples, boost, fit
from benchmarks.people.torso.training import template_source, tree_source
from ppaas.perception.torso.models import LEAVES, NODES, SHAPE, Trees
from ppaas.perception.torso.patches import COLUMNS, LOWEST, ROW_HEIGHT, ROWS

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


def samples() -> Samples:
    """Return people, who have a row of step 5 at the top of the head, among noise."""
    rng = np.random.default_rng(0)
    patches = rng.integers(0, 3, (40, ROWS, COLUMNS)).astype(np.uint8)
    tops = np.zeros(40)
    tops[:20] = rng.choice([1.2, 1.3, 1.6, 1.7, 1.8], 20)
    for patch, top in zip(patches[:20], tops[:20], strict=True):
        patch[round((top - LOWEST) / ROW_HEIGHT)] = 5
    return Samples(patches, tops)


@pytest.fixture(scope="module")
def fitted() -> Fitted:
    return fit(samples(), rounds=2)


def test_fitted_templates_find_people_and_their_heads(fitted: Fitted) -> None:
    known = samples()
    match = fitted.templates().match(known.patches)
    assert ((match.odds > 0.0) == (known.tops > 0.0)).all()
    np.testing.assert_allclose(match.top[:20], known.tops[:20], atol=0.03)


def test_source_texts_have_the_numbers(fitted: Fitted) -> None:
    found = dict[str, object]()
    exec(template_source(fitted), found)
    assert len(found["WEIGHTS"]) == 2  # type: ignore[arg-type]
    assert np.prod(SHAPE) * 5 / 4 < len("".join(str(found["WEIGHTS"]).split()))
    trees = Trees(
        np.full((3, NODES), 300, np.uint16), np.zeros((3, NODES), np.uint8), np.ones((3, LEAVES), np.float32), -1.0
    )
    text = tree_source(trees)
    assert "BIAS = -1.0000" in text
    assert all(len(line) <= 120 for line in text.splitlines())
