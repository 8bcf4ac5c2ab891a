"""Linear elasticity, perfectly plastic at a limit of strength.

==================  ================================================================
``mohr_coulomb``    with the strength of Mohr and Coulomb
``smooth_cones``    with the cones of Drucker and Prager and of Matsuoka and Nakai
==================  ================================================================
"""
