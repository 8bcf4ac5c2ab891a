"""What engine, API and client tell each other, each defined once (docs/decisions/0020-records-once.md).

Frozen dataclasses of the standard library: importing them costs next to nothing, FastAPI makes schemas of them, the
client reads answers into them. Fields as in the HTTP contract; units kN, m, day, degree, seconds where named so.

===============  ==========================================================================
``record``       how a record is written; one page of a listing
``states``       states of jobs, evaluations and keys
``job``          a job, what happens to it: events, and the cycles of its search
``evaluation``   one forward calculation, its attempts, its columns in tables, the best one
``fit``          measured points with what was calculated there
``remedy``       what to do about a finding
``statistics``   what the stored evaluations of a job tell
``uncertainty``  what its follow-ups have found, a sample of the posterior, the response surface
``arrays``       how arrays are read and written
``progress``     how far a job is within its generation, and what its follow-ups would cost
``account``      what an owner sets up in a service: API keys with their roles, hooks
``service``      the service itself: its health and workers, what it has to do, and who asks
``problem``      what a check of a problem says, and what forward models have
===============  ==========================================================================
"""
