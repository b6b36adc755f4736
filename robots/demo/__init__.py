"""Demo: starts a cloud, drives simulated robots to goals, and scores them by their true poses."""
