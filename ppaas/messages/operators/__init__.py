"""Messages between the operators of a robot and its clone."""
