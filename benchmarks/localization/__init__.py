"""Bench of localization: its accuracy, recovery and speed, simulated and on recorded logs."""
