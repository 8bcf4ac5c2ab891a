"""What the solver needs of the system below it.

===============  =============================================================
``processes``    process trees: memory and end
``environment``  variables of processes that calculate, and which forward models see
``file_locks``   locks of files
``versions``     versions of what numbers depend on
``extras``       packages that are optional
===============  =============================================================
"""
