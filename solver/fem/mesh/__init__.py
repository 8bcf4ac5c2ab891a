"""Meshes of six-node triangles.

=================  =========================================================================================
``mesh``           the mesh that the solver works on; mid-side nodes and edges of six-node triangles
``checks``         what can be wrong with a mesh
``split``          opens a mesh along lines, with interfaces between the two sides
``columns``        where the columns of a section's mesh stand
``layered``        structured meshes of layered sections that follow their geometry
``reading``        meshes of other programs, through meshio
``writing``        results as VTU and PVD files
``cross_section``  the geometry of a layered section in plain numbers: what a mesh is built from and follows
=================  =========================================================================================
"""
