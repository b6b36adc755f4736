"""Templates and trees of the upper body."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.perception.torso.models import (
    ABOVE,
    BELOW,
    DEPTH,
    LEAVES,
    LEGS,
    NODES,
    SHAPE,
    TOPS,
    Trees,
    UpperBody,
    rows_of,
)
from ppaas.perception.torso.patches import COLUMNS, LOWEST, ROW_HEIGHT, ROWS, STEPS


def blank() -> list[np.ndarray]:
    return [np.zeros(SHAPE, np.float32) for _ in TOPS]


def test_rows_of_a_template_count_from_the_head_and_those_of_the_legs_from_the_floor() -> None:
    rows, own = rows_of(1.75)
    head = round((1.75 - LOWEST) / ROW_HEIGHT)
    assert rows[own == ABOVE] == head
    assert rows[own == ABOVE + BELOW] == head - BELOW
    assert rows[-LEGS:].tolist() == list(range(LEGS))


@pytest.mark.parametrize("top", [1.5, 1.75, 1.2])
def test_the_best_match_finds_the_height_of_the_head(top: float) -> None:
    """A template that rewards step 3 in the row of the head finds the only row of that step."""
    weights = blank()
    for weight in weights:
        weight[ABOVE, :, 3] = 1.0
    patch = np.zeros((1, ROWS, COLUMNS), np.uint8)
    patch[0, round((top - LOWEST) / ROW_HEIGHT)] = 3
    match = UpperBody(weights, [-1.0, -1.0]).match(patch)
    assert match.top[0] == pytest.approx(top)
    assert match.odds[0] == pytest.approx(COLUMNS - 1.0)


def test_templates_are_the_same_for_mirror_images() -> None:
    rng = np.random.default_rng(0)
    templates = UpperBody([rng.normal(size=SHAPE).astype(np.float32) for _ in TOPS], [0.0, 0.0])
    patches = rng.integers(0, STEPS, (5, ROWS, COLUMNS)).astype(np.uint8)
    np.testing.assert_allclose(templates.odds(patches), templates.odds(patches[:, :, ::-1]), rtol=1e-4, atol=1e-4)


def naive(trees: Trees, sample: list[int]) -> float:
    odds = trees.bias
    for features, limits, leaves in zip(trees.features, trees.limits, trees.leaves, strict=True):
        node = 0
        for _ in range(DEPTH):
            node = 2 * node + (2 if sample[features[node]] > limits[node] else 1)
        odds += float(leaves[node - NODES])
    return odds


@given(st.integers(0, 1 << 20), st.integers(1, 6), st.integers(0, 8))
def test_odds_are_the_sum_of_the_leaves_that_decisions_lead_to(seed: int, count: int, samples: int) -> None:
    rng = np.random.default_rng(seed)
    trees = Trees(
        rng.integers(0, 10, (count, NODES)).astype(np.uint16), rng.integers(0, 32, (count, NODES)).astype(np.uint8),
        rng.normal(size=(count, LEAVES)).astype(np.float32), float(rng.normal()),
    )  # fmt: skip
    values = rng.integers(0, 32, (samples, 10)).astype(np.uint8)
    np.testing.assert_allclose(trees.odds(values), [naive(trees, row.tolist()) for row in values], rtol=1e-4, atol=1e-4)
