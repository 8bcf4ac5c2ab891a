"""The published laboratory studies of Meier et al. (2008) run again through the engine, beside the published numbers.

==================  =================================================================
``published``       the numbers of the paper
``study``           what the studies share: sampling over seeds, swarm, rows of a table
``oedometer``       application A
``isotropic``       application B
``slope``           application C
``slope_pictures``  its figures
``page``            tables as CSV, one page for all studies
==================  =================================================================
"""

from __future__ import annotations

from geoswarm.paper.isotropic import run_isotropic
from geoswarm.paper.oedometer import run_oedometer
from geoswarm.paper.page import write_page, write_study
from geoswarm.paper.slope import run_slope
from geoswarm.paper.study import Row, Study

__all__ = ["Row", "Study", "run_isotropic", "run_oedometer", "run_slope", "write_page", "write_study"]
