"""Child processes: limits, progress, orderly ends."""
