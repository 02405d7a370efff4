"""Touch put to work: features charted, and the servo on an arm."""
