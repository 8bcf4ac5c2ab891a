"""Soil laws behind one binary interface.

=====================  ==============================================================================
``base``               what a law declares: parameters, state variables, initial state, stress update
``binary``             the stress update as a function pointer, and how kernels call it
``drucker_prager``     perfectly plastic with the cone of Drucker and Prager
``elastic``            linear isotropic elasticity
``matsuoka_nakai``     perfectly plastic with the strength of Matsuoka and Nakai
``modified_cam_clay``  modified Cam clay
``mohr_coulomb``       perfectly plastic with the strength of Mohr and Coulomb
``soft_soil``          soft soil creep without creep
``soft_soil_creep``    soft soil creep
``registry``           finds laws, those of other packages too
=====================  ==============================================================================
"""
