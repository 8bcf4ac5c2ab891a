"""A process that ends with everything it has started, and when this program dies, by what the system offers.

==============  ==============================================================================
``tree``        what all have in common, and the choice between them
``keeper``      POSIX: a process between this one and the run; it kills what is below it when this one is gone
``job_object``  Windows: what belongs to a job ends when its last handle is closed
==============  ==============================================================================
"""
