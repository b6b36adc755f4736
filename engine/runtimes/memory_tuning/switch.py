"""Switch of all memory tuning: the environment variable ``PPAAS_LEAN``; any value but ``0`` is on.

Each process reads it once. It is inherited with the environment, so a cloud, its agents and its containers agree.
"""

import os

NAME, OFF = "PPAAS_LEAN", "0"

LEAN = os.environ.get(NAME) != OFF
"""Whether this process tunes its memory."""
