"""A run's state on disk, and back."""
