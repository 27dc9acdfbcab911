"""Contact conditions at the nodes and their exact tangent."""
