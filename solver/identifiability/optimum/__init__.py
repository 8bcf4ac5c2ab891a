"""Uncertainty at the optimum: standard errors, intervals, profiles, other basins.

=================  ====================================================================================================
``sensitivity``    standard errors and intervals
``linearisation``  what they are calculated from
``differences``    sensitivities as one parallel generation
``combinations``   combinations that the data leave open
``profiles``       profile objectives and their intervals
``bending``        intervals where the model is nonlinear
``polish``         Levenberg-Marquardt from an optimum
``basins``         stored runs that fit as well elsewhere
``hidden``         where a basin like that of the optimum could still hide: what no run has come near, or where runs
                   were left alone
``leaving_out``    the optimum without each of several tests: which of them pulls, and how far the estimates of whole
                   tests scatter
``minimising``     the step from an optimum to the minimum of the linearised objective, inside the bounds (Karush, Kuhn
                   and Tucker)
``refitted``       the minimum without each of several tests by forward runs, and the intervals that follow
``spread``         spread of the estimates around the optimum: covariance, standard errors, half widths of intervals
=================  ====================================================================================================
"""
