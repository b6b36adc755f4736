"""Node ``people_coordinator``: the people whom the robots of a group see, and who follows whom."""
