"""Trained templates and trees of the torso detector, from the numbers in `template_weights` and `tree_weights`."""

import base64
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.perception.torso import template_weights, tree_weights
from ppaas.perception.torso.models import LEAVES, NODES, SHAPE, Trees, UpperBody


@cache
def trained_templates() -> UpperBody:
    """Return the templates."""
    source = template_weights
    weights = [
        _numbers(text, "i1").reshape(SHAPE).astype(np.float32) * np.float32(scale)
        for text, scale in zip(source.WEIGHTS, source.SCALES, strict=True)
    ]
    return UpperBody(weights, list(source.BIASES))


@cache
def trained_trees() -> Trees:
    """Return the trees."""
    source = tree_weights
    leaves = _numbers(source.LEAVES, "i1").reshape(-1, LEAVES).astype(np.float32) * np.float32(source.SCALE)
    return Trees(
        _numbers(source.FEATURES, "<u2").reshape(-1, NODES), _numbers(source.LIMITS, "u1").reshape(-1, NODES), leaves,
        source.BIAS,
    )  # fmt: skip


def _numbers(text: str, kind: str) -> NDArray[Any]:
    """Return numbers of a type from their bytes as base85."""
    return np.frombuffer(base64.b85decode("".join(text.split())), kind)
