"""What the kernels know of a body in one phase, and its state."""

from __future__ import annotations

from typing import NamedTuple

from geoswarm.solver.arrays import BoolArray, FloatArray, IntArray
from geoswarm.solver.fem.mesh.mesh import IndexArray

__all__ = ["Body", "State", "copied"]


class Body(NamedTuple):
    """Elements, materials and the way they deform; fixed during a phase.

    ``constants`` (m, c) are those of the soils' laws, ``updates`` (m,) the addresses of their stress updates,
    ``strength`` (m, 5) the places of their strength in the constants, -1: none, and ``elastic`` (m, 2) bulk and shear
    modulus of perfectly plastic ones, 0: none; ``tensors`` (m, t) where tensors among the state variables begin, -1:
    none, with what they keep of shear, ``tensor_shear`` (m, t); ``interface_constants`` as in
    :mod:`geoswarm.solver.fem.materials`; ``material`` (e,) and ``interface_material`` (k,) index them, -1: inactive.
    ``edges`` (q, 3) carry follower loads.
    """

    axisymmetric: bool
    updated: bool
    triangles: IndexArray
    material: IntArray
    updates: IntArray
    constants: FloatArray
    strength: IntArray
    elastic: FloatArray
    tensors: IntArray
    tensor_shear: FloatArray
    interfaces: IndexArray
    interface_material: IntArray
    interface_constants: FloatArray
    edges: IndexArray
    edge_elements: IntArray  # (q,): the triangle that each edge belongs to
    edge_places: IntArray  # (q, 3): numbers of the edge's nodes in that triangle


class State(NamedTuple):
    """State at the integration points: ``stress`` (e, 3, 4) kPa, tension positive; ``internal`` (e, 3, s), the
    state variables of the laws; ``plastic`` (e, 3); ``traction`` (k, 3, 2) kPa, normal (tension positive) and shear;
    ``gap`` (k, 3), m, how far sides are apart.
    """

    stress: FloatArray
    internal: FloatArray
    plastic: BoolArray
    traction: FloatArray
    gap: FloatArray


def copied(state: State) -> State:
    """A state of its own arrays."""
    stress, internal, plastic, traction, gap = state
    return State(stress.copy(), internal.copy(), plastic.copy(), traction.copy(), gap.copy())
