"""The client side: what runs on a robot, simulated robots, and the command line. The modules here are aliases."""
