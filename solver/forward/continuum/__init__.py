"""Forward models of two-dimensional bodies: sections of slopes and embankments, and meshes of the user.

===============  =======================================================================================================
``body``         what sections and meshes of the user have in common in a problem file: materials, phases, what is
                 observed
``fields``       displacements and strains of a whole body, for plots: which models have a body, and what is drawn of it
``geometry``     the geometry of a section in a problem file, and its numbers for given parameters
``materials``    materials of a body in a problem file: constants that are numbers or expressions of parameters
``model``        the forward model of a body: from parameters to displacements of points over time and over periods
``phases``       what happens to a body, in phases, in a problem file
``quantity``     numbers of a problem's section that may be given as expressions of parameters: ``30``, or ``"1.2 *
                 depth"``
``sketch``       the sketch of a section: its geometry as given, without a mesh
``translation``  from a problem's materials and phases to those of the finite elements, for given parameters
``user_mesh``    a mesh of the user in a problem file: the name of a file beside it, or the mesh itself as tables
===============  =======================================================================================================
"""
