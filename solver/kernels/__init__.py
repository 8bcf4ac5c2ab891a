"""What all numerical kernels share; :mod:`geoswarm.solver.warm` has them compiled ahead of the first calibration.

=========  ================================================
``jit``    how they are compiled, the same everywhere
``cache``  where they are kept, and which are there already
=========  ================================================
"""
