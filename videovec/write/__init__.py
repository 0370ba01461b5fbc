"""What comes out: pure functions from tracks to text, bytes and pictures."""
