"""Buildings in the process of the master: their devices, and the controllers of their lifts and doors."""
