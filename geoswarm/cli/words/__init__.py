"""What commands print: tables, notes, errors, warnings.

==================  =================================================================================================
``error_messages``  every error becomes one clear message on stderr and an exit code; warnings, and runs of a user's
                    program
``kernels``         compiles kernels before a command calculates, and shows that it does
``output``          numbers, tables and JSON as the user reads them; names, symbols and units in tables
``result``          how a result is shown: the verdict on the fit first, then values with intervals and verdicts, and
                    what to do next
==================  =================================================================================================
"""
