"""Command ``ppaas bridge`` and its bridges."""
