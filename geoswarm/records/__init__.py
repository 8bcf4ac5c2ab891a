"""What engine, API and client tell each other, each defined once (docs/decisions/0020-records-once.md).

Frozen dataclasses of the standard library: importing them costs next to nothing, FastAPI makes schemas of them, the
client reads answers into them. Fields as in the HTTP contract; units kN, m, day, degree, seconds where named so.

===============  ==========================================================================
``record``       how a record is written
``states``       states of jobs, evaluations and keys
``page``         one page of a listing
``job``          a job
``generation``   one cycle of its search
``evaluation``   one forward calculation, its attempts, its columns in tables, the best one
``event``        what happens to a job
``fit``          measured points with what was calculated there
``remedy``       what to do about a finding
``statistics``   what the stored evaluations of a job tell
``uncertainty``  what its follow-ups have found, a sample of the posterior
``worker``       who runs forward calculations
``key``          API keys and roles
``hook``         whom to tell when a job has ended
``arrays``       how arrays are read and written
``progress``     how far a job is within its generation, and what its follow-ups would cost
===============  ==========================================================================
"""
