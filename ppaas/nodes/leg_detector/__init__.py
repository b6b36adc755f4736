"""Node ``leg_detector``: finds people in laser scans."""
