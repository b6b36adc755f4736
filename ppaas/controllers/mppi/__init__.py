"""Model predictive path integral control (MPPI): averages random command sequences by their costs."""
