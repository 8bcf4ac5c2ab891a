"""Search methods: ask for a generation, tell its objectives, take a snapshot. They never call an objective.

==========================  ==========================================================================================
``space``                   bounds, search coordinates, feasibility; how widely a generation is scattered
``determinism``             the same numbers in any order and on any number of workers: random numbers, one thread for
                            linear algebra
``particle_swarm``          the synchronous particle swarm of the published study
``differential_evolution``  the synchronous one of Storn and Price
``acceleration``            proposals learned from all runs so far
``monte_carlo``             random, Latin hypercube and Sobol points; points that are given
``descent``                 the way down to a minimum, and the points around it
``bounded``                 linear least squares inside bounds
``base``                    the protocol of a search method
``runs``                    what has been calculated: positions, weighted residual vectors
==========================  ==========================================================================================
"""
