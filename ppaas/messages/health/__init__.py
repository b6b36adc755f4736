"""Messages on how a robot is: diagnostics."""
