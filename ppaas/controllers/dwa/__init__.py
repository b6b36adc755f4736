"""Dynamic window approach: the best of the velocities that the robot can reach within one cycle."""
