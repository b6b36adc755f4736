"""Node ``follow_person``: follows the person whom the coordinator assigns to its robot, by Move Base."""
