"""Commands for programs as forward models: ``geoswarm model new`` and ``geoswarm model try``."""
