"""The people bench: simulated robots track, count and follow people, beside bars and other rules."""
