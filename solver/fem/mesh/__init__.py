"""Meshes of six-node triangles.

========  ==========================================
``mesh``  the mesh that the solver works on
========  ==========================================
"""
