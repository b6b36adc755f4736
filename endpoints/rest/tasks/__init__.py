"""Routes of the tasks of the caller's robots on a map."""
