"""Fleet: plans for many robots on one map that keep out of each other's way."""
