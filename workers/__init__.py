"""The distributed engine: store, coordinator, worker processes and the service that the API sees.

===============  ======================================================================
``states``       what jobs and evaluations are and become: pure functions
``store``        the database: tables, migrations, connections
``queries``      what is read from and written to its tables
``access``       API keys, sign-ins, quotas
``coordinator``  applies events to the store: claims, results, generations, endings
``operations``   sweeps, retention, probes, measures
``execution``    what a worker does with a claim
``service``      what clients ask of jobs
``notices``      tells whoever asked for it that a job has ended
``hosts``        where workers live: embedded, or in Celery's processes
===============  ======================================================================
"""

from __future__ import annotations

if __name__ != "geoswarm.workers":  # from a checkout Python would find the folder by its bare name, as a second copy
    raise ImportError("import geoswarm.workers: workers is a part of geoswarm and has no name of its own")
