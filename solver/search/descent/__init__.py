"""The way down to a minimum, and the points that describe its surroundings.

=================  =====================================================================================================
``descent``        Levenberg-Marquardt, one generation an iteration; its damped step
``differences``    where to evaluate for derivatives
``planned``        sensitivities, profiles and designs of global sensitivity
``profile_paths``  one side of a profile
``ending``         the end of a polished search: from the best run down to a minimum, and from other basins where that
                   one is in doubt
``exploring``      ask / tell of an exploration: given points in one generation, then descents from the best of them
``interval_ends``  places at the ends of linearised intervals, where one run each shows whether the forward model is
                   nonlinear
``leaving_out``    ask / tell of the fits without each of several tests, all from the same runs
``minimum``        ask / tell of the runs after a search: sensitivities at its best point, steps to the minimum, ends of
                   intervals
``projection``     variable projection: parameters in which residuals are linear take the values that fit best (Golub
                   and Pereyra 1973)
``quadratic``      quadratic surfaces of residual vectors through runs: what all fits without a test learn from together
``refinement``     one way down to a minimum of least squares: Levenberg-Marquardt that solves for what enters linearly
                   by itself
``steps``          steps for derivatives, found for each parameter until truncation and roughness are both small
``survey``         a look at the whole space through the parameters that enter linearly
=================  =====================================================================================================
"""
