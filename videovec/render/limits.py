"""Where the definition of coverage stops being smooth, and what the back ends do there alike.

Ends of lines and dots. The profile across a line, taken around its end, would be too much ink there: a pixel's square
reaches half a pixel beyond the end of a hairline, at full strength. With q the half-width in kernel sides, its mass
around an end is m(q) times that of half a disc, where for a kernel that is a box

    m = 2 q / 3 + 1 / (2 q)  for q < 1/2,    m = 1 + 1 / (12 q^2)  above,

so that distances from an end are measured m times as long along the tangent, and those from a dot (a stroke without
length, hence without tangent) sqrt(m) times as long in every direction. Ends and dots of any width then have the mass
that they should have.
"""

from __future__ import annotations

__all__ = ["BENT", "NARROWEST", "NEAREST", "SLOWEST", "THINNEST"]

NARROWEST = 1e-3
"""Least extent of the projected pixel's shorter side, in pixels: keeps the trapezoid's flanks finite."""
SLOWEST = 0.1
"""Below this speed |B'| a curve has no tangent worth the name. px per unit of t"""
NEAREST = 1e-3
"""Below this distance an end has no direction to the pixel. px"""
THINNEST = 0.05
"""Least half-width, in kernel sides, for which the reach of a line's end is made right."""
BENT = 0.05
"""Least B'² - r·B'' in terms of B'²: pixels at the centre of curvature would have unbounded gradients."""
