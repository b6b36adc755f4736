"""How well localization holds a robot and finds it again, and how fast it is: simulated, and on recorded logs."""
