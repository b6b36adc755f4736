"""Routes of the traffic of the caller's robots on a map."""
