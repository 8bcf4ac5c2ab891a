"""Forward models: from parameter values to calculated series.

A *spec* (pydantic, the ``forward_model`` section of a problem file) builds a *model*
(:class:`~geoswarm.solver.forward.base.ForwardModel`).
Specs are found through the entry point group ``geoswarm.forward_models``; any installed package can add a kind.

=========================  =============================================================================================
``base``                   the protocol that every forward model speaks
``combined``               several forward models calibrated at once, such as an oedometer and an isotropic compression
                           test of one soil
``continuum``              forward models of two-dimensional bodies: sections of slopes and embankments, and meshes of
                           the user
``cross_section``          a vertical section through a layered slope or embankment, in plane strain; its geometry may
                           be identified
``diagram``                diagrams that engineers draw of a test, of one series over another: declared by the test,
                           drawn by reports
``fields``                 what sections of several forward models have in common: fields, their checks, one material
                           with its law
``finite_element``         a plane body on the user's own mesh of triangles
``formula``                forward model given by expressions: for teaching, for tests of the method and for quick curve
                           fits
``isolation``              runs that may end their process: they are made in a process of their own where there is not
                           one already
``isotropic_compression``  isotropic compression test: a cylindrical specimen under all-round pressure in stages
``oedometer``              oedometer test: one-dimensional compression of a confined specimen under vertical loads in
                           stages
``programs``               forward models that we did not write: sections and models, with :mod:`.foreign` below them
``registry``               finds forward models by their kind: those of this package and those that other packages offer
                           as entry points
``specimen``               a laboratory specimen as a boundary value problem: a cylinder of six-node triangles in
                           axisymmetry
``staged_history``         how a staged test is calculated: by the fast path of its law, by the general driver, or with
                           finite elements
``staged_load``            what the forward models of laboratory tests with constant loads in stages share
``staged_section``         what the laboratory tests with constant loads in stages share in their sections of the
                           problem file
=========================  =============================================================================================
"""

from __future__ import annotations

from geoswarm.solver.forward.base import ForwardModel, ForwardModelSpec, ForwardRun, ParameterInfo, SeriesInfo

__all__ = ["ForwardModel", "ForwardModelSpec", "ForwardRun", "ParameterInfo", "SeriesInfo"]
