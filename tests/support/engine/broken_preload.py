"""A preload module that cannot be loaded."""

import sys

sys.exit("broken on purpose")
