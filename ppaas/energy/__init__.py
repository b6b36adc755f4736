"""Energy of robots: batteries, whose models are learnt, and places where robots charge and park."""
