"""The client layer: what runs on a robot, and simulated robots that stand in for real ones."""
