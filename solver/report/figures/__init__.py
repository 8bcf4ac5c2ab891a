"""The figures of a run (matplotlib, without a display and its global state).

======================  ==============================================================================================
``compression_plot``    figure of a compression curve: void ratio, or strain downwards, over the logarithm of stress
``construction_plot``   figure of the constructions of a classical evaluation: readings, lines and results, one panel
                        each
``cross_section_plot``  figures of a body: its mesh, its deformed mesh, and displacement vectors measured against
                        calculated
``diagram_plot``        figures of diagrams that engineers draw of a test, and of several tests in one: measured and
                        calculated
``extent``              limits of axes that can be drawn, whatever numbers they come from: finite, and different from
                        each other
``figure_set``          the figures of a run by name: each is drawn when it is asked for, as SVG, PNG, or the numbers
                        behind it as CSV
``fit_plot``            fit plots: measured and calculated series with their residuals, and stage by stage over the
                        logarithm of time
``intervals_plot``      what is known of each parameter, between the bounds it was searched in
``labels``              symbols, units and scales of parameters, for axes and tables
``matrix_plot``         the matrix plot of a statistical analysis (Meier et al
``outlook``             figures of what comes next: predictions, and the worth of further tests
``profile_plot``        displacement over depth below points of the surface: how much of it the shear zone takes
``progress_plots``      how the search went: objective and parameters over the evaluations
``sketch_plot``         the sketch of a test as a figure: the same shapes as in the form of a new job
``style``               how every figure looks, and how it becomes a file: one palette, one set of sizes, one lock
``uncertainty_plots``   figures of what follow-ups and a posterior sample have found: profiles, distributions, indices
======================  ==============================================================================================
"""
