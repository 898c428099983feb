"""What is true of triangles and boxes at one instant."""
