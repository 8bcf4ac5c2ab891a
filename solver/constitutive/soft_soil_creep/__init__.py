"""Soft soil creep.

==================  ========================================================================================
``physics``         parameters and the scalar physics of the model
``step``            one time step where Mohr-Coulomb flow plays no part, in a plane or general: the fast way
``general_update``  one time step for a general stress, to which the fast way leaves all others
==================  ========================================================================================
"""
