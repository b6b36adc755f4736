"""Routes of the people whom the caller's robots see on a map."""
