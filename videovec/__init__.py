"""Line-art clips to Bézier strokes with one identity over the whole clip."""

__version__ = "0.1.0"
