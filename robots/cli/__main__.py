"""``python -m robots.cli`` is ``ppaas``."""

import sys

from robots.cli.main import main

sys.exit(main())
