"""The distributed engine: store, coordinator, worker processes and the service that the API sees.

=================  =====================================================================================================
``states``         what jobs and evaluations are and become: pure functions
``store``          the database: tables, migrations, connections
``queries``        what is read from and written to its tables
``access``         API keys, sign-ins, quotas
``coordinator``    applies events to the store: claims, results, generations, endings
``operations``     sweeps, retention, probes, measures
``execution``      what a worker does with a claim
``service``        what clients ask of jobs
``notices``        notifications of jobs that have ended
``hosts``          where workers live: embedded, or in Celery's processes
``agents``         agents: workers without the database, that reach the service by HTTP. What is given to them, and what
                   they bring
``cache``          what was made lately, kept in memory and made by one thread at a time
``child_process``  what the service hands to a child process on its standard input
``errors``         everything that can go wrong in the engine
``identity``       identity of a worker process, and how others on the same machine see at once that it has died
``logs``           log records on stderr, as text or as one JSON object a line; secrets are made unreadable in both
``secrets``        keeps secrets out of logs, and refuses those that everybody knows
``settings``       settings of the engine, from code or from the environment
``tracing``        traces for OpenTelemetry, when it is installed (``geoswarm[tracing]``) and an exporter is named; else
                   nothing
``waker``          the waker: notifies workers that a job may have work
=================  =====================================================================================================
"""

from __future__ import annotations

if __name__ != "geoswarm.workers":  # from a checkout Python would find the folder by its bare name, as a second copy
    raise ImportError("import geoswarm.workers: workers is a part of geoswarm and has no name of its own")
