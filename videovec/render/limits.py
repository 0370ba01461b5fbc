"""Where the definition of coverage stops being smooth, and what the back ends do there alike."""

from __future__ import annotations

__all__ = ["BENT", "NARROWEST", "NEAREST", "SLOWEST"]

NARROWEST = 1e-3
"""Least extent of the projected pixel's shorter side, in pixels: keeps the trapezoid's flanks finite."""
SLOWEST = 0.1
"""Below this speed |B'| a curve has no tangent worth the name. px per unit of t"""
NEAREST = 1e-3
"""Below this distance an end has no direction to the pixel. px"""
BENT = 0.05
"""Least B'² - r·B'' in terms of B'²: pixels at the centre of curvature would have unbounded gradients."""
