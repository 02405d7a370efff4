"""How points, solids and lines look in every picture and page of a fit."""

PANEL = "#F6F7F9"
"""Background."""
SOLID = "#8DB3D9"
"""Colour of a solid: light, so that points inside it keep theirs."""
SOLID_OPACITY = 0.45
POINT_SIZE = 0.017
"""Diameter of a drawn point, in sides of a panel."""
CURVE_WIDTH = 0.006
"""Width of a feature line, in sides of a panel."""
CURVE = "#22262B"
"""Feature lines: the ink of all charts."""
HIDDEN_CURVE = "#8A919B"
"""Feature lines behind the solid."""
