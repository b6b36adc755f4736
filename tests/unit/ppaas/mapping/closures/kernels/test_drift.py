import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ppaas.mapping.closures.kernels.drift import path_moments
from tests.reference.mapping import closures as twin


def compressed(n, edges):
    """Return edges as rows of neighbours."""
    rows = [[] for _ in range(n)]
    for i, j, length, sign in edges:
        rows[i].append((j, length, sign))
        rows[j].append((i, length, -sign))
    starts = np.cumsum([0] + [len(row) for row in rows])
    flat = np.array([entry for row in rows for entry in row], float).reshape(-1, 3)
    return starts, flat[:, 0].astype(np.int64), flat[:, 1].copy(), flat[:, 2].copy()


@given(st.integers(0, 2**32 - 1))
def test_moments_equal_those_of_the_twin(seed):
    rng = np.random.default_rng(seed)
    n = 12
    edges = [(k, k + 1, rng.uniform(0.1, 1.0), 1.0) for k in range(n - 3)]
    edges += [(int(i), int(j), 0.2, 0.0) for i, j in rng.integers(0, n - 2, (3, 2)) if i != j]
    positions = rng.normal(size=(n, 2))
    found = path_moments(4, *compressed(n, edges), positions)
    np.testing.assert_allclose(found, twin.path_moments(4, n, edges, positions), atol=1e-9)
    assert np.isinf(found[n - 1, 0])
