"""Chaos bench: random faults in a cloud under driving robots; what was lost, repeated or left behind."""
