"""Links: the web process's ends of the control link (machines) and of the robot link (containers)."""
