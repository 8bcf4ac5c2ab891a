"""Forward models of two-dimensional bodies: sections of slopes and embankments, and meshes of the user."""
