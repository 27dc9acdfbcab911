"""Error estimates, decisions, new meshes, state carried over."""
