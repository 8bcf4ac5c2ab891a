"""What engine, API and client tell each other, each defined once (docs/decisions/0020-records-once.md).

Frozen dataclasses of the standard library: importing them costs next to nothing, FastAPI makes schemas of them, the
client reads answers into them. Fields as in the HTTP contract; units kN, m, day, degree, seconds where named so.

==============  =====================================================================
``record``      how a record is written
``states``      states of jobs, evaluations, workers and keys
``page``        one page of a listing
``evaluation``  an evaluation, its columns in tables, the best one
==============  =====================================================================
"""
