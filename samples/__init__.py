"""Sample clips of our own, with the strokes that they were drawn from."""
