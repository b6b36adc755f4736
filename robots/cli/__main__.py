"""Entry point ``python -m robots.cli``, the same as ``ppaas``."""

import sys

from robots.cli.main import main

sys.exit(main())
