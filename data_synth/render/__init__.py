"""Depth rendering: renderers by OpenGL and by ray casting, depth noise, a synthetic camera."""
