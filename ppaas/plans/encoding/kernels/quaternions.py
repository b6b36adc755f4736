"""Kernel: predictions of headings as qz and qw.

Results are identical on every machine: only additions, multiplications, divisions and square roots are used, which IEEE
754 defines to the last bit. The sines of C libraries differ. The series are those of fdlibm's ``k_sin.c`` and
``k_cos.c`` (Sun Microsystems, 1993); the result is nearly always the nearest float64.
"""

import math

from ppaas.kernel_cache.decorators import compiled
from ppaas.plans.encoding.kernels.grid_moves import QUATERNIONS

HALF_PI, HALF_PI_REST = 1.5707963267948966, 6.123233995736766e-17
_QUARTER_PI = 0.7853981633974483
_BEHIND = float(QUATERNIONS[4, 1])

_S1, _S2, _S3 = -1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04
_S4, _S5, _S6 = 2.75573137070700676789e-06, -2.50507602534068634195e-08, 1.58969099521155010221e-10
_C1, _C2, _C3 = 4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05
_C4, _C5, _C6 = -2.75573143513906633035e-07, 2.08757232129817482790e-09, -1.13596475577881948265e-11


@compiled
def _sine(x: float, rest: float) -> float:
    """Return the sine of x + rest, for angles from 0 to π/4 [rad]."""
    z = x * x
    v = z * x
    r = _S2 + z * (_S3 + z * (_S4 + z * (_S5 + z * _S6)))
    return x - ((z * (0.5 * rest - v * r) - rest) - v * _S1)


@compiled
def _cosine(x: float, rest: float) -> float:
    """Return the cosine of x + rest, for angles from 0 to π/4 [rad]."""
    z = x * x
    r = z * (_C1 + z * (_C2 + z * (_C3 + z * (_C4 + z * (_C5 + z * _C6)))))
    half = 0.5 * z
    whole = 1.0 - half
    return whole + (((1.0 - whole) - half) + (z * r - x * rest))


@compiled
def quaternion_near(yaw: float) -> tuple[float, float]:
    """Return qz, qw of a yaw from −π to π [rad], nearly always correctly rounded; a fixed result for other yaws."""
    half = min(abs(yaw) * 0.5, 2.0)
    if half <= _QUARTER_PI:
        sine, cosine = _sine(half, 0.0), _cosine(half, 0.0)
    else:
        left = HALF_PI - half
        sine, cosine = _cosine(left, HALF_PI_REST), _sine(left, HALF_PI_REST)
    return (-sine if yaw < 0.0 else sine), cosine


@compiled
def quaternion_towards(x: float, y: float) -> tuple[float, float]:
    """Return qz, qw of the heading along (x, y), accurate to a few units in the last place."""
    length = math.sqrt(x * x + y * y)
    if not 0.0 < length < math.inf:
        return 0.0, 1.0
    cosine, sine = x / length, abs(y) / length
    larger = math.sqrt((1.0 + abs(cosine)) * 0.5)
    smaller = sine / (2.0 * larger)
    qz, qw = (smaller, larger) if cosine >= 0.0 else (larger, smaller)
    if y == 0.0 and x < 0.0:
        qw = _BEHIND
    return (-qz if y < 0.0 else qz), qw


def warm() -> None:
    """Call the kernels once."""
    quaternion_near(1.0)
    quaternion_towards(1.0, 1.0)
