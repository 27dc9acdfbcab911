"""An independent look at accepted states, on plain arrays."""
