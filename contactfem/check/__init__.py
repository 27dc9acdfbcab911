"""What is said about a case before it runs."""
