"""What stores do, measured beside yardsticks."""
