"""Chaos bench: random faults in a cloud with driving robots; reports what was lost, repeated or left behind."""
