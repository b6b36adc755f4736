"""The switch for all memory tuning: the environment variable ``PPAAS_LEAN``, which is on unless it is ``0``.

It is read once a process, and inherited with the environment, so a cloud, its agents and its containers agree on it.
"""

import os

NAME, OFF = "PPAAS_LEAN", "0"

LEAN = os.environ.get(NAME) != OFF
"""Whether this process tunes its memory."""
