"""Kernel: depth images in RVL, a lossless run-length code.

Source: Wilson, *Fast lossless depth image compression*, ACM ISS 2017; the class ``RvlCodec`` of ROS's
``compressed_depth_image_transport``, which keeps its layout. Numbers are written in groups of three bits, the least
first, each in a nibble whose highest bit says that another one follows. Eight nibbles fill a word, the first in its
highest bits; words are little-endian.
"""

import numpy as np
from numba import types
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled

_MOST_NIBBLES = 11
"""Nibbles of a number of 32 bits."""


@compiled(types.int64(types.Array(types.uint32, 1, "C", readonly=True), types.uint16[::1]))
def expand_rvl(words: NDArray[np.uint32], pixels: NDArray[np.uint16]) -> int:
    """Decode an image: again and again a number of zeros, a number of other depths, and these as differences.

    Parameters
    ----------
    words : (w,) uint32 array
        Code; what follows the image is ignored.
    pixels : (n,) uint16 array
        Out: depths, row by row.

    Returns
    -------
    int
        Number of pixels that were decoded; fewer than n if the code ends before, or is none.
    """
    nibbles, place, pixel, previous = 8 * len(words), 0, 0, 0
    run, left, zeros = 0, 0, False
    while pixel < len(pixels):
        # A number: the length of a run, or a difference within one.
        value, count, more = 0, 0, True
        while more:
            if place == nibbles or count == _MOST_NIBBLES:
                return pixel
            nibble = (int(words[place >> 3]) >> (28 - 4 * (place & 7))) & 15
            value |= (nibble & 7) << (3 * count)
            more = nibble >= 8
            place, count = place + 1, count + 1
        if left == 0:
            zeros = not zeros
            run = value
            if run > len(pixels) - pixel:
                return pixel
            if zeros:
                pixels[pixel : pixel + run] = 0
                pixel += run
            else:
                left = run
            continue
        previous += (value >> 1) ^ -(value & 1)
        pixels[pixel] = previous & 0xFFFF
        pixel, left = pixel + 1, left - 1
    return pixel


def warm() -> None:
    """Call the kernel once."""
    expand_rvl(np.zeros(1, np.uint32), np.zeros(1, np.uint16))
