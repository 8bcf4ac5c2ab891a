"""Requests that calculate, in processes of their own: what one of them does can neither stop nor slow the others.

==============  ===============================================================================
``middleware``  sends them there, each in its owner's turn, and answers when nothing came of it
``fair_queue``  whose turn it is
``pool``        the processes: made when needed, the one that knows the job first
``process``     one of them: asked over a socket of this machine, watched, ended at its limits
==============  ===============================================================================

What runs in them, the same application behind no door, is :mod:`geoswarm.api.compute_program`.
"""
