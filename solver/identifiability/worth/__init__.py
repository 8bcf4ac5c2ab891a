"""Which test next: how much candidate readings would add to the data of a job.

==============  ======================================================
``candidates``  the file of candidates: tests, readings, errors, costs
``question``    the problem of the follow-up job
``outcome``     expected reductions, from its evaluations
==============  ======================================================
"""
