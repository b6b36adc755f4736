"""Model predictive path integral control: many random rollouts, averaged by their costs."""
