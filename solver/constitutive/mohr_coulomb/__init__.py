"""Linear elasticity with the limit of Mohr and Coulomb.

===========  ============================================================================
``limit``    the limit with dilatancy and tension cut-off as planes in principal stresses
``step``     one step, in a plane and for a general stress
===========  ============================================================================
"""
