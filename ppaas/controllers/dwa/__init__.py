"""Dynamic window approach: chooses the best of the velocities that the robot can reach within one cycle."""
