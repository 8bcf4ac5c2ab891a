"""Laws in libraries behind the binary interface; :mod:`geoswarm.solver.user_laws` has their sections in a problem.

=================  ============================
``umat_bridge``    user routines of Abaqus
``mfront_bridge``  generic behaviours of MFront
``calls``          what both bridges share
=================  ============================
"""
