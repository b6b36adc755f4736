import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ppaas.perception.torso.models import DEPTH, LEAVES, NODES, Trees


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
