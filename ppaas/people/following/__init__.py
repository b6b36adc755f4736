"""Following of a person by one robot: decides where it drives, and where it searches."""
