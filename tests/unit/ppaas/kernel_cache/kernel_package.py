"""A package of two kernels that replaces this project's, and a program that calls one."""

from pathlib import Path

import ppaas

LOWER = """
from numba import njit

STEP = {step}

@njit(cache=True)
def lower(number):
    return number + STEP
"""

UPPER = """
from numba import njit

from ppaas.room.kernels.lower import lower

@njit(cache=True)
def upper(number):
    return lower(number)
"""

ASK = """
import ppaas
ppaas.__path__.insert(0, {folder!r})
from ppaas.room.kernels.upper import upper
print(upper(1), sum(upper.stats.cache_hits.values()))
"""


def package_of(folder: Path) -> Path:
    """Create the package in a folder, and return its own."""
    kernels = folder / "ppaas" / "room" / "kernels"
    kernels.mkdir(parents=True)
    (kernels.parent / "__init__.py").touch()
    real = Path(ppaas.__path__[0], "planners", "kernels", "__init__.py")
    (kernels / "__init__.py").write_text(real.read_text())
    (kernels / "lower.py").write_text(LOWER.format(step=1))
    (kernels / "upper.py").write_text(UPPER)
    return folder / "ppaas"
