"""Uncertainty at the optimum: standard errors, intervals, profiles, other basins.

=================  ===============================================================
``sensitivity``    standard errors and intervals
``linearisation``  what they are calculated from
``differences``    sensitivities as one parallel generation
``combinations``   combinations that the data leave open
``profiles``       profile objectives and their intervals
``bending``        intervals where the model is nonlinear
``polish``         Levenberg-Marquardt from an optimum
``basins``         stored runs that fit as well elsewhere
=================  ===============================================================
"""
