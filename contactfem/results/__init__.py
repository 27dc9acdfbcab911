"""What a run hands over, and numbers measured on it."""
