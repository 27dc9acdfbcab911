"""Fields from one mesh to another."""
