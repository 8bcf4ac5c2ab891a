"""The report: its contents, as HTML and PDF.

======================  ================================================================================================
``build``               :class:`Report`: statistics, figures, HTML and PDF
``content``             contents of a report, in order
``captions``            headings and captions of the figures of a report
``html``                the report as one HTML page that needs nothing else: no script, no request, light and dark, wide
                        and narrow
``laboratory``          tables of classical evaluation and back-analysis: readings, calculated curve, index properties,
                        identified values
``laboratory_table``    table and JSON of the parameters in the laboratory's terms
``outlook_tables``      tables of predictions, and of the worth of further tests
``parts``               the parts of a report: cards, pictures, tables
``pdf``                 the report as a PDF on A4: ReportLab sets text and tables, the figures are those of the page as
                        PNG
``readings``            what a report says of the readings: where they come from, what was done to them, and those that
                        do not count
``residual_table``      the table of the residuals at the optimum
``reweighted``          stored evaluations under other weights, as the HTTP interface and the command line show them
``scope``               what the forward model of a laboratory test does not contain, for a report to say
``series_table``        the table of the series in the objective, with the shares of their tests
``uncertainty_tables``  tables of what follow-ups and a posterior sample have found
======================  ================================================================================================
``html``, ``pdf``   its two forms (need the ``plots`` extra)
==================  =======================================================
"""
