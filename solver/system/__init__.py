"""What the solver needs of the system below it.

===============  ======================================================================================================
``processes``    process trees: memory and end
``environment``  variables of processes that calculate, and which forward models see
``file_locks``   locks of files
``versions``     versions of what numbers depend on
``extras``       packages that are optional
``activity``     what an evaluation does besides calculating: it waits for its turn, or reads
``installed``    finds what is installed by its kind: what this package has, and what others offer as entry points of a
                 group
===============  ======================================================================================================
"""
