"""Methods: each module declares a section of the problem file, what it plans, its words, and makes its search.

==========================  =========================================================================================
``base``                    what every method declares
``widths``                  how many runs a generation has, where the problem does not say so
``registry``                finds built-in methods and those of other packages
``particle_swarm``          a search
``differential_evolution``  a search
``monte_carlo``             a sampling
``sensitivity``             a follow-up: derivatives at an optimum
``profile``                 a follow-up: profile objectives
``jackknife``               a follow-up: the fits without each of several tests
``global_designs``          follow-ups: Sobol indices, elementary effects of Morris
``design``                  sensitivities of candidate tests at the optimum of a job and at draws around it: which of
                            them would tell most
``explore``                 looking for further basins, away from an optimum
``given_points``            what follow-ups have in common whose points are all in their problem
``predict``                 the identified parameters of a job with their uncertainty, run through a forward model
==========================  =========================================================================================
"""
