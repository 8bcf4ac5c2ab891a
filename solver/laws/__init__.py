"""Soil laws behind one binary interface.

======================  ==============================================================================
``base``                what a law declares: parameters, state variables, initial state, stress update
``binary``              the stress update as a function pointer, and how kernels call it
``elastic``             linear isotropic elasticity
``perfect_plasticity``  Mohr-Coulomb, Drucker-Prager, Matsuoka-Nakai
``hardening_soil``      hardening soil: shear surface and cap
``modified_cam_clay``   modified Cam clay
``soft_soil``           soft soil creep without creep
``soft_soil_creep``     soft soil creep
``hypoplasticity``      clay and sand, with intergranular strain
``libraries``           user routines of Abaqus and behaviours of MFront
``usual_parameters``    parameters that many laws share, and what they demand of each other
``at_rest``             stress at rest from K0 and the history of load
``registry``            finds laws, those of other packages too
======================  ==============================================================================

The physics of a law is in :mod:`geoswarm.solver.constitutive`.
"""
