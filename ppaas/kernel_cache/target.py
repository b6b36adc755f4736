"""Processor that kernels are compiled for: a level of x86-64, where the computer has it.

numba compiles for the processor on which it runs, and its cache is valid on the same model only. Kernels that are
compiled for a level run on every processor of this level, with the same results to the last bit: those of an image or a
wheel are used wherever it is installed. Vectors of 512 bits, which the level lacks, are not lost: LLVM prefers 256 bits
on processors that have both.
"""

import os

from llvmlite import binding

LEVEL = "x86-64-v3"
"""Processors since 2013 (Intel's Haswell) and 2015 (AMD's Excavator), as LLVM calls them."""

NAME, FEATURES = "NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES"

_OF_LEVEL = ("avx", "avx2", "bmi", "bmi2", "cx16", "f16c", "fma", "lzcnt", "movbe", "popcnt", "sahf", "sse4.2", "xsave")
"""Features of the level (x86-64 psABI, micro-architecture levels)."""


def compile_target() -> tuple[str, str]:
    """Return name and features of the processor that kernels of this process are compiled for, as numba takes them.

    ``NUMBA_CPU_NAME`` and ``NUMBA_CPU_FEATURES`` select another one.
    """
    name, features = os.environ.get(NAME), os.environ.get(FEATURES)
    if name is None and features is None and has_level():
        return LEVEL, ""
    if features is None:
        features = "" if (name or "").lower() == "generic" else binding.get_host_cpu_features().flatten()
    return name or binding.get_host_cpu_name(), features


def has_level() -> bool:
    """Return whether this computer has all features of the level."""
    try:
        found = binding.get_host_cpu_features()
    except RuntimeError:  # LLVM does not know this processor
        return False
    return all(found.get(feature, False) for feature in _OF_LEVEL)


def export_target() -> None:
    """Make numba compile for the target in this process and its children; call it before numba is imported."""
    if NAME not in os.environ and FEATURES not in os.environ and has_level():
        os.environ[NAME], os.environ[FEATURES] = LEVEL, ""


def use_target() -> None:
    """Make numba compile for the target in this process, unless it has compiled for another one already.

    It compiles for one processor only, which the first kernel of a process decides.
    """
    from numba.core import config  # noqa: PLC0415  # takes a third of a second, and `export_target` needs none of it
    from numba.core.registry import cpu_target  # noqa: PLC0415

    is_free = config.CPU_NAME is None and config.CPU_FEATURES is None  # type: ignore[attr-defined]
    if is_free and "_toplevel_target_context" not in vars(cpu_target) and has_level():
        config.CPU_NAME, config.CPU_FEATURES = LEVEL, ""  # type: ignore[attr-defined]
