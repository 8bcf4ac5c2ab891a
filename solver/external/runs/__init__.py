"""One run of a user's program.

================  ========================================================================
``fingerprints``  what distinguishes versions of a file
``sources``       the files that each run gets, read once
``folder``        a new folder for each run, and which of them are kept
``program``       starts a program, bounds its time and output, ends its process tree
``slots``         how many runs at once on this machine
``secrets``       values that no message may show
``verdict``       whether a run has succeeded, and else why not
================  ========================================================================
"""
