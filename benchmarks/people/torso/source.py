"""Source texts of the trained numbers of the torso detector."""

import base64

import numpy as np
from numpy.typing import NDArray

from benchmarks.people.torso.template_fit import Fitted
from ppaas.perception.torso.models import Trees

WIDTH = 112
"""Number of characters of a line."""

PROGRAM = "``python -m benchmarks.people.torso.training``"


def template_source(fitted: Fitted) -> str:
    """Return the source text of ``ppaas/perception/torso/template_weights.py``."""
    scales = [float(np.abs(weights).max()) / 127.0 for weights in fitted.weights]
    lines = [
        f'"""Weights of the templates, fitted by {PROGRAM}."""',
        "",
        f"SCALES = ({', '.join(f'{scale:.6g}' for scale in scales)})",
        '"""Value of one unit of the weights of each posture."""',
        "",
        f"BIASES = ({', '.join(f'{bias:.4f}' for bias in fitted.biases)})",
        '"""Bias of each posture."""',
        "",
        "WEIGHTS = (",
    ]
    for weights, scale in zip(fitted.weights, scales, strict=True):
        lines += ['    """', *_lines(np.rint(weights / scale).astype("i1"), "    "), '    """,']
    lines += [")", '"""Weights of each posture, int8 as base85, in the order of `template.SHAPE`."""', ""]
    return "\n".join(lines)


def tree_source(trees: Trees) -> str:
    """Return the source text of ``ppaas/perception/torso/tree_weights.py``."""
    scale = float(np.abs(trees.leaves).max()) / 127.0
    lines = [
        f'"""Trees that tell people from what looks like them, fitted by {PROGRAM}."""',
        "",
        f"BIAS = {trees.bias:.4f}",
        '"""Log odds without trees."""',
        "",
        f"SCALE = {scale:.6g}",
        '"""Value of one unit of the leaves."""',
    ]
    parts = {
        "FEATURES": (trees.features.astype("<u2"), "Feature of each decision, uint16, little-endian, as base85."),
        "LIMITS": (trees.limits, "Limit of each decision, uint8 as base85."),
        "LEAVES": (np.rint(trees.leaves / scale).astype("i1"), "Leaves, int8 as base85."),
    }
    for name, (numbers, text) in parts.items():
        lines += ["", f'{name} = """', *_lines(numbers), '"""', f'"""{text}"""']
    return "\n".join([*lines, ""])


def _lines(numbers: NDArray[np.generic], indent: str = "") -> list[str]:
    text = base64.b85encode(numbers.tobytes()).decode()
    return [indent + text[k : k + WIDTH] for k in range(0, len(text), WIDTH)]
