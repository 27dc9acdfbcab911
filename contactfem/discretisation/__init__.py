"""From a case to equations, and the state between steps."""
