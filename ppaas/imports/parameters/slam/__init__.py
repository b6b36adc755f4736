"""Parameter files of programs that make maps: slam_toolbox, gmapping and cartographer."""
