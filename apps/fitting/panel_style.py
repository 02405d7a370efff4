"""Colours and sizes of points, solids and lines in all pictures and pages of a fit."""

PANEL = "#F6F7F9"
"""Colour of the background."""
SOLID = "#8DB3D9"
"""Colour of a solid. It is light, so that points inside keep their colour."""
SOLID_OPACITY = 0.45
POINT_SIZE = 0.017
"""Diameter of a point, relative to the side of a panel."""
CURVE_WIDTH = 0.006
"""Width of a feature line, relative to the side of a panel."""
CURVE = "#22262B"
"""Colour of feature lines: the ink of all charts."""
HIDDEN_CURVE = "#8A919B"
"""Colour of feature lines behind the solid."""
