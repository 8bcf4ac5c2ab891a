"""Soil laws behind one binary interface.

========================  ==============================================================================================
``base``                  what a law declares: parameters, state variables, initial state, stress update
``binary``                the stress update as a function pointer, and how kernels call it
``elastic``               linear isotropic elasticity
``perfect_plasticity``    Mohr-Coulomb, Drucker-Prager, Matsuoka-Nakai
``hardening_soil``        hardening soil: shear surface and cap
``modified_cam_clay``     modified Cam clay
``soft_soil_creep``       soft soil creep, and soft soil, the same without creep
``hypoplasticity``        clay and sand, with intergranular strain
``libraries``             user routines of Abaqus and behaviours of MFront
``usual_parameters``      parameters that many laws share, and what they demand of each other
``registry``              finds laws, those of other packages too
``hardening_soil_small``  the hardening soil model with small-strain stiffness as a law
``hardening_soil_terms``  what parameters of hardening soil are in the terms of laboratories
``initial_state``         the state before a test: void ratio, from the section or the law; stress at rest, from K0 and
                          the load history
``sources``               where the usual ranges of parameters come from: publications, and what is said where there is
                          none
``terms``                 how parameters of a law translate into the terms of laboratories, and back
========================  ==============================================================================================

The physics of a law is in :mod:`geoswarm.solver.constitutive`.
"""
