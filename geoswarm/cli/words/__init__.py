"""What commands print: tables, notes, errors, warnings.

==================  =================================================================================================
``error_messages``  every error becomes one clear message on stderr and an exit code; warnings, and runs of a user's
                    program
``kernels``         compiles kernels before a command calculates, and shows that it does
``labels``          names, symbols and units of parameters and series in tables
``output``          numbers, tables and JSON as the user reads them: results on stdout, everything else on stderr
``result``          how a result is shown: the verdict on the fit first, then values with intervals and verdicts, and
                    what to do next
``spans``           spans of time on the command line: ``90d``, ``12h``, ``30m``, ``45s``
==================  =================================================================================================
"""
