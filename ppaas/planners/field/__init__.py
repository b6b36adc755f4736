"""Fields of costs-to-go, which searches grow over a map from a goal."""
