"""Soil laws behind one binary interface.

=====================  ==============================================================================
``base``               what a law declares: parameters, state variables, initial state, stress update
``binary``             the stress update as a function pointer, and how kernels call it
``drucker_prager``     perfectly plastic with the cone of Drucker and Prager
``elastic``            linear isotropic elasticity
``hardening_soil``     hardening soil: shear surface and cap
``hypoplasticity``     what hypoplastic laws share
``hypoplastic_clay``   hypoplasticity of clay, with intergranular strain
``hypoplastic_sand``   hypoplasticity of sand, with intergranular strain
``matsuoka_nakai``     perfectly plastic with the strength of Matsuoka and Nakai
``modified_cam_clay``  modified Cam clay
``mohr_coulomb``       perfectly plastic with the strength of Mohr and Coulomb
``soft_soil``          soft soil creep without creep
``soft_soil_creep``    soft soil creep
``usual_parameters``   parameters that many laws share, and what they demand of each other
``at_rest``            stress at rest from K0 and the history of load
``umat_bridge``        user routines of Abaqus behind the interface
``mfront_bridge``      generic behaviours of MFront behind it
``library_calls``      what both bridges share
``registry``           finds laws, those of other packages too
=====================  ==============================================================================
"""
