"""Arrays of several dimensions in CBOR (RFC 8746), as clients read them."""

from typing import Any

import numpy as np


def array_in(tagged: Any) -> np.ndarray:
    """Return the array of several dimensions of a CBOR item."""
    assert tagged.tag == 40
    shape, numbers = tagged.value
    assert numbers.tag == 86
    return np.frombuffer(numbers.value, "<f8").reshape(shape)
