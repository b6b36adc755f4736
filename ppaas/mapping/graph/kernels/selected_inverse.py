"""Kernel: the diagonal blocks of the inverse of a factorised matrix.

Takahashi, Fagan, Chen, 1973; by supernodes as in Lin et al., *SelInv*, ACM TOMS 37(4), 2011. With the columns P of a
front and its rows R below them, G = L_RP L_PP⁻¹, the inverse Z has Z_RP = −Z_RR G and Z_PP = (L_PP L_PPᵀ)⁻¹ − Gᵀ Z_RP.
Z_RR is in the columns of the front's ancestors, which are computed before it.
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.mapping.graph.kernels.fronts import one_block

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]


@compiled
def inverse_diagonal(starts: Ints, row_starts: Ints, rows: Ints, panel_starts: Ints, panels: Floats) -> Floats:
    """Return the blocks (n, 3, 3) on the diagonal of (L Lᵀ)⁻¹, by block column.

    Parameters
    ----------
    starts, row_starts, rows, panel_starts, panels : array
        Fronts and factor, as in ``fronts``.
    """
    count, n = starts.size - 1, starts[-1]
    owner = np.empty(n, np.int64)
    for s in range(count):
        owner[starts[s] : starts[s + 1]] = s
    inverse = np.empty_like(panels)  # panels of Z, laid out as those of L
    blocks = np.empty((n, 3, 3))
    for s in range(count - 1, -1, -1):
        width, height = 3 * (starts[s + 1] - starts[s]), 3 * (row_starts[s + 1] - row_starts[s])
        factor = panels[panel_starts[s] : panel_starts[s + 1]].reshape(width, height)
        result = inverse[panel_starts[s] : panel_starts[s + 1]].reshape(width, height)
        below = rows[row_starts[s] + width // 3 : row_starts[s + 1]]
        known = _known_inverse(below, owner, starts, row_starts, rows, panel_starts, inverse)
        gain = _gain(factor)
        # Rows below the columns.
        for c in range(width):
            target = result[c, width:]
            target[:] = 0.0
            for q in range(height - width):
                for r in range(height - width):
                    target[r] -= gain[c, q] * known[q, r]
        # The columns themselves.
        _square_of_inverse(factor, result)
        for c in range(width):
            for d in range(width):
                for r in range(height - width):
                    result[c, d] -= gain[c, r] * result[d, width + r]
        for c in range(width):
            for b in range(3):
                blocks[starts[s] + c // 3, c % 3, b] = result[c, c - c % 3 + b]
    return blocks


@compiled
def _known_inverse(
    below: Ints, owner: Ints, starts: Ints, row_starts: Ints, rows: Ints, panel_starts: Ints, inverse: Floats
) -> Floats:
    """Return Z between block rows, from the panels of the supernodes that own them."""
    count = below.size
    known = np.empty((3 * count, 3 * count))
    for j in range(count):
        s = owner[below[j]]
        first, last = row_starts[s], row_starts[s + 1]
        stride = 3 * (last - first)
        for i in range(j, count):
            row = 3 * np.searchsorted(rows[first:last], below[i])
            for a in range(3):
                source = panel_starts[s] + (3 * (below[j] - starts[s]) + a) * stride + row
                for b in range(3):
                    known[3 * j + a, 3 * i + b] = known[3 * i + b, 3 * j + a] = inverse[source + b]
    return known


@compiled(fastmath={"contract"})
def _gain(factor: Floats) -> Floats:
    """Return Gᵀ = (L_RP L_PP⁻¹)ᵀ of a panel."""
    width = factor.shape[0]
    gain = factor[:, width:].copy()
    for c in range(width - 1, -1, -1):
        for d in range(c + 1, width):
            for r in range(gain.shape[1]):
                gain[c, r] -= factor[c, d] * gain[d, r]
        for r in range(gain.shape[1]):
            gain[c, r] /= factor[c, c]
    return gain


@compiled(fastmath={"contract"})
def _square_of_inverse(factor: Floats, result: Floats) -> None:
    """Write (L_PP L_PPᵀ)⁻¹ into the first columns of a panel."""
    width = factor.shape[0]
    # Columns of L_PP⁻¹, as rows of an upper triangle.
    columns = np.zeros((width, width))
    for d in range(width):
        columns[d, d] = 1.0
        for c in range(d, width):
            columns[d, c] /= factor[c, c]
            for r in range(c + 1, width):
                columns[d, r] -= factor[c, r] * columns[d, c]
    for c in range(width):
        for d in range(c, width):
            total = 0.0
            for r in range(d, width):
                total += columns[c, r] * columns[d, r]
            result[c, d] = result[d, c] = total


def warm() -> None:
    """Call the kernel once, so that it is compiled or loaded from the cache."""
    starts, row_starts, rows, _, panel_starts = one_block()
    inverse_diagonal(starts, row_starts, rows, panel_starts, np.eye(3).ravel())
