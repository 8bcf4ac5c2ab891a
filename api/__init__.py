"""The HTTP side of geoswarm: routes, live events, problem details and a first dashboard, on top of ``workers``.

==============  ===============================================================================
``app``         :func:`create_app`: everything below put together
``settings``    API key, allowed hosts, limits
``server``      :func:`serve`: uvicorn on a port that is checked first, with a quick, graceful stop
``errors``      what goes wrong, as RFC 9457 problem details
``gate``        API key, host and origin checks
``headers``     security headers of every answer
``bodies``      reads a problem document from a request: size limit, media type, duplicate keys
``feed``        one poller a watched job, many listeners: the source of the event streams
``schemas``     the models of every response
``routes``      one module a resource
``pages``       the HTML pages at ``/`` and ``/jobs/{id}``
==============  ===============================================================================
"""

from __future__ import annotations

from api.app import create_app
from api.errors import ApiError, PortInUseError
from api.server import bind, serve
from api.settings import ApiSettings

__all__ = ["ApiError", "ApiSettings", "PortInUseError", "bind", "create_app", "serve"]
