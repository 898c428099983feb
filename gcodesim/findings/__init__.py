"""What can be said about a program or a model, and what it means."""
