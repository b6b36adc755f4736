"""How many examples the tests of hostile bytes try; ``make fuzz`` tries a hundred thousand."""

import os

EXAMPLES = int(os.environ.get("PPAAS_FUZZ_EXAMPLES", "30"))
