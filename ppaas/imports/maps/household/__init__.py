"""Maps of robots at home: vacuum robots and lawn mowers."""
