"""Linear elasticity with the limit of Mohr and Coulomb.

===========  ============================================================================
``limit``    the limit with dilatancy and tension cut-off as planes in principal stresses
``planar``   one step in a plane
``general``  the same for a general stress
===========  ============================================================================
"""
