"""From identified parameters to a prediction: what their uncertainty makes of another forward model.

============  ====================================================================
``shapes``    how the parameters scatter around one optimum
``draws``     a sample of the parameters: all basins with their weights, truncated
``bands``     median, band and basins of every series from the runs of a sample
``question``  the problem of the follow-up job
============  ====================================================================
"""
