"""The HTTP side of geoswarm: routes, live events, problem details and the dashboard, on top of ``workers``.

===================  ===================================================================================================
``app``              :func:`create_app`: everything below put together
``settings``         API key, allowed hosts, limits
``server``           :func:`serve`: uvicorn on a port that is checked first, with a quick, graceful stop
``errors``           what goes wrong, as RFC 9457 problem details
``access``           the door: keys, sessions, hosts, origins; limits of size, number and time
``compute``          processes that read, build and report, with limits of their own; ``compute_program`` runs in them
``events``           one poller a watched job, many listeners: the source of the event streams
``schemas``          the models of every response
``routes``           one module a resource
``pages``            the dashboard: one module a page; its scripts use the routes
``assets``           static files and Plotly, compressed, kept by browsers
``compute_program``  the program of a process for requests that calculate: the same application, behind no door
``dependencies``     what routes ask for: the service, the feed, and the errors that they document
``drafts``           checks drafts of problems, and finds the starter examples
``headers``          security headers of every answer
``observe``          counts, times, logs and traces every request; by the route's template, never by what a client wrote
``parquet``          evaluations as Parquet: typed columns, written row group by row group into a temporary file (extra
                     ``parquet``)
``points``           the successful evaluations of a job as one block of float32, for plots of many thousand points
``views``            the view of a job's statistics: threshold, known noise, posterior sample; documents as records
===================  ===================================================================================================
"""

from __future__ import annotations

if __name__ != "geoswarm.api":  # from a checkout Python would find the folder by its bare name, as a second copy
    raise ImportError("import geoswarm.api: api is a part of geoswarm and has no name of its own")

from geoswarm.api.app import create_app
from geoswarm.api.errors import ApiError, PortInUseError
from geoswarm.api.server import bind, serve
from geoswarm.api.settings import ApiSettings

__all__ = ["ApiError", "ApiSettings", "PortInUseError", "bind", "create_app", "serve"]
