"""What pictures ask of the bodies: distances, and what an eye sees."""
