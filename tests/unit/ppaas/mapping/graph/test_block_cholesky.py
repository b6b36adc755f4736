import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.mapping.graph.block_cholesky import BlockCholesky
from tests.reference.mapping import pose_graph as twin


def random_matrix(count, pairs, seed):
    """Return pairs and blocks of a random positive definite matrix."""
    random = np.random.default_rng(seed)
    ends = np.sort(random.integers(0, count, (pairs, 2)), axis=1)
    keys = np.unique(ends[ends[:, 0] < ends[:, 1]] @ [count, 1])
    first, second = keys // count, keys % count
    off_diagonal = random.normal(size=(len(keys), 3, 3))
    diagonal = random.normal(size=(count, 3, 3)) * 0.1
    diagonal = diagonal @ np.swapaxes(diagonal, 1, 2) + 0.1 * np.eye(3)
    for block, i, j in zip(off_diagonal, first, second, strict=True):
        diagonal[i] += np.abs(block).sum() * np.eye(3)
        diagonal[j] += np.abs(block).sum() * np.eye(3)
    return first, second, diagonal, off_diagonal


def agree(found, expected):
    """Return whether arrays agree as by `pytest.approx`, which compares element by element."""
    return (np.abs(found - expected) <= np.maximum(1e-9 * np.abs(expected), 1e-12)).all()


@settings(deadline=None)
@given(st.integers(1, 60), st.integers(0, 150), st.integers(0, 1000))
def test_solution_agrees_with_a_dense_solver(count, pairs, seed):
    first, second, diagonal, off_diagonal = random_matrix(count, pairs, seed)
    random = np.random.default_rng(seed)
    damping, right = random.uniform(0.0, 1.0, (count, 3)), random.normal(size=(count, 3, 2))
    factor = BlockCholesky(count, first, second)
    assert factor.factorise(diagonal, off_diagonal, damping)
    matrix = twin.dense(diagonal, off_diagonal, first, second) + np.diag(damping.ravel())
    expected = np.linalg.solve(matrix, right.reshape(3 * count, 2))
    assert agree(factor.solve(right).reshape(3 * count, 2), expected)
    assert agree(factor.solve(right[:, :, 0]).ravel(), expected[:, 0])


def test_factor_can_be_computed_again_for_other_numbers():
    first, second, diagonal, off_diagonal = random_matrix(40, 80, 1)
    factor, right = BlockCholesky(40, first, second), np.ones((40, 3))
    assert factor.factorise(diagonal, off_diagonal, np.zeros((40, 3)))
    once = factor.solve(right)
    assert factor.factorise(2.0 * diagonal, 2.0 * off_diagonal, np.zeros((40, 3)))
    assert factor.solve(right) == pytest.approx(once / 2.0)


def test_matrix_that_is_not_positive_definite_is_refused():
    first, second, diagonal, off_diagonal = random_matrix(40, 80, 1)
    diagonal[17, 1, 1] = -1.0
    factor = BlockCholesky(40, first, second)
    assert not factor.factorise(diagonal, off_diagonal, np.zeros((40, 3)))
    diagonal[17, 1, 1] = np.nan
    assert not factor.factorise(diagonal, off_diagonal, np.zeros((40, 3)))


def test_matrix_without_rows_has_an_empty_solution():
    none = np.empty(0, np.int64)
    factor = BlockCholesky(0, none, none)
    assert factor.factorise(np.empty((0, 3, 3)), np.empty((0, 3, 3)), np.empty((0, 3)))
    assert factor.solve(np.empty((0, 3))).shape == (0, 3)
