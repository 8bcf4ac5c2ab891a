"""Linear elasticity, perfectly plastic at a limit of strength.

==================  ================================================================
``mohr_coulomb``    with the strength of Mohr and Coulomb
``drucker_prager``  with the cone of Drucker and Prager, and what smooth cones share
``matsuoka_nakai``  with the strength of Matsuoka and Nakai
==================  ================================================================
"""
