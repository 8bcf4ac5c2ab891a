"""Soil laws behind one binary interface.

=====================  ==============================================================================
``base``               what a law declares: parameters, state variables, initial state, stress update
``binary``             the stress update as a function pointer, and how kernels call it
``elastic``            linear isotropic elasticity
``modified_cam_clay``  modified Cam clay
``mohr_coulomb``       perfectly plastic with the strength of Mohr and Coulomb
``soft_soil``          soft soil creep without creep
``soft_soil_creep``    soft soil creep
``registry``           finds laws, those of other packages too
=====================  ==============================================================================
"""
