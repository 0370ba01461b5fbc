"""The differentiable 2D Gaussian renderer of strokes, in closed form."""
