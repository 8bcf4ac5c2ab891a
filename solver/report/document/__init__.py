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
``readings``            readings: where they are from, what was done to them, what the model lacks; residuals
``series_table``        the table of the series in the objective, with the shares of their tests
``uncertainty_tables``  tables of what follow-ups and a posterior sample have found
======================  ================================================================================================
``html``, ``pdf``   its two forms (need the ``plots`` extra)
==================  =======================================================
"""
