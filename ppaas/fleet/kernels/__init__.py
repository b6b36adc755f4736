"""Inner loops of fleet plans."""
