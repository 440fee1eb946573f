"""Training of the recurrent network that finds the ball in events (docs/training.md)."""
