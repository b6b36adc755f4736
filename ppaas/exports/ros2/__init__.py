"""Export of a robot as a set-up of Nav2 and slam_toolbox that drives it as its clone does."""
