"""Kernels: multifrontal Cholesky factorisation of a symmetric matrix with blocks of 3 × 3, and its triangular solves.

Duff, Reid, *The multifrontal solution of indefinite sparse symmetric linear equations*, ACM TOMS 9(3), 1983; Liu, *The
multifrontal method for sparse matrix solution*, SIAM Review 34(1), 1992.

Arrays that describe the fronts, as ``elimination_tree`` makes them:

``starts`` (s + 1,), ``row_starts`` (s + 1,), ``rows`` (r,), ``children`` (s,)
    First block column of each supernode; start of the block rows of its front; the block rows; number of its children.
``panel_starts`` (s + 1,), ``panels`` (p,)
    Start of the columns of the factor that belong to a supernode, and these columns. A panel is a dense array of
    (3 w, 3 h) numbers, column by column, for w block columns and h block rows; above its diagonal is no data.
"""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]


@compiled
def stack_size(starts: Ints, row_starts: Ints, children: Ints) -> int:
    """Return the largest total size of the update matrices that wait for their parents [numbers]."""
    waiting, depth = np.empty(children.size, np.int64), 0
    total = largest = np.int64(0)
    for s in range(children.size):
        for _ in range(children[s]):
            depth -= 1
            total -= waiting[depth]
        below = row_starts[s + 1] - row_starts[s] - (starts[s + 1] - starts[s])
        if below:
            waiting[depth] = 9 * below * below
            total += waiting[depth]
            depth += 1
        largest = max(largest, total)
    return int(largest)


@compiled
def factorise(
    starts: Ints,
    row_starts: Ints,
    rows: Ints,
    children: Ints,
    panel_starts: Ints,
    entry_starts: Ints,
    entry_rows: Ints,
    entry_slots: Ints,
    diagonal: Floats,
    off_diagonal: Floats,
    damping: Floats,
    stack: Floats,
    panels: Floats,
) -> int:
    """Factorise H + D into L Lᵀ; return −1, or the first column whose pivot is not positive.

    Parameters
    ----------
    starts, row_starts, rows, children, panel_starts : array
        Fronts, see above.
    entry_starts : (n + 1,) array
        Start of the blocks of H below the diagonal of each block column.
    entry_rows, entry_slots : (m,) array
        Block row of each, and its index in ``off_diagonal``; the complement ~k if block k is to be transposed.
    diagonal : (n, 3, 3) array
        Blocks of H on its diagonal, by column.
    off_diagonal : (m, 3, 3) array
        Blocks of H below its diagonal.
    damping : (n, 3) array
        Diagonal of D.
    stack : array of ``stack_size`` numbers
        Scratch space for update matrices.
    panels : (p,) array
        The factor; overwritten.
    """
    highest = np.int64(0)
    for s in range(children.size):
        highest = max(highest, row_starts[s + 1] - row_starts[s])
    space = np.empty(9 * highest * highest)
    place = np.empty(starts[-1], np.int64)  # row of a block row in the current front
    # Update matrices that wait for their parents: size, rows (of the front that made them) and end in the stack.
    waiting, depth, used = np.empty(children.size, np.int64), 0, 0
    for s in range(children.size):
        width, height = starts[s + 1] - starts[s], row_starts[s + 1] - row_starts[s]
        size = 3 * height
        front = space[: size * size].reshape(size, size)
        front[:] = 0.0
        for k in range(height):
            place[rows[row_starts[s] + k]] = 3 * k
        # Assembly: the blocks of the columns of this supernode.
        for column in range(starts[s], starts[s + 1]):
            c = place[column]
            for a in range(3):
                for b in range(a, 3):
                    front[c + a, c + b] = diagonal[column, b, a]
                front[c + a, c + a] += damping[column, a]
            for k in range(entry_starts[column], entry_starts[column + 1]):
                r, slot = place[entry_rows[k]], entry_slots[k]
                for a in range(3):
                    for b in range(3):
                        front[c + a, r + b] = off_diagonal[slot, b, a] if slot >= 0 else off_diagonal[~slot, a, b]
        # Assembly: the update matrices of the children (extend-add).
        for _ in range(children[s]):
            depth -= 1
            child = waiting[depth]
            first = row_starts[child] + starts[child + 1] - starts[child]
            count = row_starts[child + 1] - first
            used -= 9 * count * count
            _extend_add(front, stack[used : used + 9 * count * count], rows[first : first + count], place)
        # Partial factorisation of the front.
        failed = _eliminate(front, 3 * width)
        if failed >= 0:
            return int(3 * starts[s] + failed)
        panels[panel_starts[s] : panel_starts[s + 1]] = space[: 3 * width * size]
        # The Schur complement waits for the parent.
        if height > width:
            count = size - 3 * width
            update = stack[used : used + count * count].reshape(count, count)
            for c in range(count):
                update[c, c:] = front[3 * width + c, 3 * width + c :]
            waiting[depth] = s
            depth += 1
            used += count * count
    return -1


@compiled
def _extend_add(front: Floats, update: Floats, rows: Ints, place: Ints) -> None:
    """Add an update matrix of the block rows ``rows``, stored column by column, to a front."""
    count = rows.size
    stride = 3 * count
    for j in range(count):
        column = place[rows[j]]
        for a in range(3):
            source = (3 * j + a) * stride
            # The diagonal block: its lower triangle alone.
            for b in range(a, 3):
                front[column + a, column + b] += update[source + 3 * j + b]
            for i in range(j + 1, count):
                row = place[rows[i]]
                for b in range(3):
                    front[column + a, row + b] += update[source + 3 * i + b]


@compiled(fastmath={"contract"})
def _eliminate(front: Floats, width: int) -> int:
    """Eliminate the first columns of a front, stored column by column, its lower triangle alone.

    They become columns of the factor, the others the Schur complement. Returns −1, or the column whose pivot is not
    positive. Left-looking, by blocks of 3 × 3: three columns take the products of three columns before them at once,
    so that each number read is used three times. What that writes above the diagonal is no data.
    """
    size = front.shape[0]
    for c in range(0, size, 3):
        t0, t1, t2 = front[c, c:], front[c + 1, c:], front[c + 2, c:]
        for q in range(0, min(c, width), 3):
            l0, l1, l2 = front[q, c:], front[q + 1, c:], front[q + 2, c:]
            a00, a01, a02 = l0[0], l1[0], l2[0]
            a10, a11, a12 = l0[1], l1[1], l2[1]
            a20, a21, a22 = l0[2], l1[2], l2[2]
            for r in range(t0.size):
                x, y, z = l0[r], l1[r], l2[r]
                t0[r] -= a00 * x + a01 * y + a02 * z
                t1[r] -= a10 * x + a11 * y + a12 * z
                t2[r] -= a20 * x + a21 * y + a22 * z
        if c < width:
            for a in range(3):
                if not _pivot(front, c, c + a):
                    return int(c + a)
    return -1


@compiled(fastmath={"contract"})
def _pivot(front: Floats, begin: int, column: int) -> bool:
    """Make a column one of the factor, with those from ``begin`` on done; return whether its pivot is positive."""
    target = front[column, column:]
    for other in range(begin, column):
        source = front[other, column:]
        factor = source[0]
        for r in range(target.size):
            target[r] -= factor * source[r]
    if not target[0] > 0.0:
        return False
    root = math.sqrt(target[0])
    target[0] = root
    for r in range(1, target.size):
        target[r] *= 1.0 / root
    return True


@compiled
def solve(starts: Ints, row_starts: Ints, rows: Ints, panel_starts: Ints, panels: Floats, values: Floats) -> None:
    """Solve L Lᵀ x = b in place.

    Parameters
    ----------
    starts, row_starts, rows, panel_starts, panels : array
        Fronts and factor, see above.
    values : (n, 3, k) array
        b of k right-hand sides, by block column; replaced by x.
    """
    count, heights = starts.size - 1, row_starts[1:] - row_starts[:-1]
    local = np.empty((3 * heights.max() if count else 0, values.shape[2]))
    for s in range(count):
        part = local[: 3 * heights[s]]
        _gather(values, rows[row_starts[s] : row_starts[s + 1]], part)
        _forward(panels[panel_starts[s] : panel_starts[s + 1]], part)
        _scatter(part, rows[row_starts[s] : row_starts[s + 1]], values)
    for s in range(count - 1, -1, -1):
        part = local[: 3 * heights[s]]
        _gather(values, rows[row_starts[s] : row_starts[s + 1]], part)
        _backward(panels[panel_starts[s] : panel_starts[s + 1]], part)
        _scatter(part, rows[row_starts[s] : row_starts[s + 1]], values)


@compiled
def _gather(values: Floats, rows: Ints, part: Floats) -> None:
    for k in range(rows.size):
        part[3 * k : 3 * k + 3] = values[rows[k]]


@compiled
def _scatter(part: Floats, rows: Ints, values: Floats) -> None:
    for k in range(rows.size):
        values[rows[k]] = part[3 * k : 3 * k + 3]


@compiled(fastmath={"contract"})
def _forward(panel: Floats, part: Floats) -> None:
    """Solve the columns of a panel, and subtract their products from the rows below."""
    size = part.shape[0]
    for c in range(panel.size // size):
        column = panel[c * size : (c + 1) * size]
        for k in range(part.shape[1]):
            x = part[c, k] / column[c]
            part[c, k] = x
            for r in range(c + 1, size):
                part[r, k] -= column[r] * x


@compiled(fastmath={"contract", "reassoc"})
def _backward(panel: Floats, part: Floats) -> None:
    """Solve the transposed columns of a panel, last column first."""
    size = part.shape[0]
    for c in range(panel.size // size - 1, -1, -1):
        column = panel[c * size : (c + 1) * size]
        for k in range(part.shape[1]):
            total = 0.0
            for r in range(c + 1, size):
                total += column[r] * part[r, k]
            part[c, k] = (part[c, k] - total) / column[c]


def one_block() -> tuple[Ints, Ints, Ints, Ints, Ints]:
    """Return the fronts of a matrix of one block: starts, row_starts, rows, children, panel_starts."""
    ends = np.array((0, 1))
    return ends, ends, np.zeros(1, np.int64), np.zeros(1, np.int64), 9 * ends


def warm() -> None:
    """Call the kernels once, so that they are compiled or loaded from the cache."""
    starts, row_starts, rows, children, panel_starts = one_block()
    none, blocks, panels = np.zeros(0, np.int64), np.eye(3)[np.newaxis], np.zeros(9)
    stack = np.zeros(stack_size(starts, row_starts, children))
    entries = np.zeros(2, np.int64), none, none
    factorise(
        starts, row_starts, rows, children, panel_starts, *entries, blocks, blocks, np.zeros((1, 3)), stack, panels
    )
    solve(starts, row_starts, rows, panel_starts, panels, np.ones((1, 3, 1)))
