"""Fast stand-ins of clones: discs that drive by the grants of a real coordinator, with late and lost messages."""
