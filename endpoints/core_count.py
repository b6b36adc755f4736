"""The number of CPUs on a command line."""

import argparse


def core_count(text: str) -> int:
    """Read it; ``ArgumentTypeError`` or ``ValueError`` where it is none."""
    cores = int(text)
    if cores < 1:
        raise argparse.ArgumentTypeError(f"containers need 1 CPU or more, not {cores}")
    return cores
