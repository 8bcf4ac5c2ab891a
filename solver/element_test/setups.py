"""Laboratory tests as stages of a material point: each function is one way to lead a specimen.

Compression positive, zz axial. Strains are logarithmic for the large strains of a real specimen whose axes do not turn,
or small strains: the equations are the same.
"""

from __future__ import annotations

from geoswarm.solver.element_test.boundary_conditions import Control, Stage, strain_change, stress_value

__all__ = [
    "confined_load",
    "constant_rate_oedometer",
    "drained_triaxial",
    "isotropic_load",
    "isotropic_strain",
    "relaxation",
    "simple_shear",
    "undrained_triaxial",
]


def _no_shear() -> tuple[Control, ...]:
    return strain_change(0.0, xy=1.0), strain_change(0.0, yz=1.0), strain_change(0.0, zx=1.0)


def _no_lateral_strain() -> tuple[Control, ...]:
    return strain_change(0.0, xx=1.0), strain_change(0.0, yy=1.0)


def confined_load(stress: float, duration: float) -> Stage:
    """Oedometer: axial ``stress``, kPa, at once, kept for ``duration``, day; no lateral strain."""
    controls = (*_no_lateral_strain(), stress_value(stress, zz=1.0), *_no_shear())
    return Stage(f"confined load {stress:g} kPa", duration, controls, instant=True)


def constant_rate_oedometer(strain: float, duration: float) -> Stage:
    """Oedometer at constant rate: axial ``strain`` more within ``duration``, day; no lateral strain."""
    controls = (*_no_lateral_strain(), strain_change(strain, zz=1.0), *_no_shear())
    return Stage(f"constant rate oedometer to {strain:g}", duration, controls)


def isotropic_load(stress: float, duration: float) -> Stage:
    """All-round ``stress``, kPa, at once, kept for ``duration``, day; drained."""
    controls = (stress_value(stress, xx=1.0), stress_value(stress, yy=1.0), stress_value(stress, zz=1.0), *_no_shear())
    return Stage(f"isotropic load {stress:g} kPa", duration, controls, instant=True)


def isotropic_strain(volume: float, duration: float) -> Stage:
    """Volume strain ``volume`` more, equal in all directions, at constant rate within ``duration``, day."""
    third = volume / 3.0
    controls = (strain_change(third, xx=1.0), strain_change(third, yy=1.0), strain_change(third, zz=1.0), *_no_shear())
    return Stage(f"isotropic strain {volume:g}", duration, controls)


def relaxation(duration: float) -> Stage:
    """All strains kept for ``duration``, day."""
    controls = (*_no_lateral_strain(), strain_change(0.0, zz=1.0), *_no_shear())
    return Stage("relaxation", duration, controls)


def drained_triaxial(strain: float, cell_pressure: float, duration: float) -> Stage:
    """Axial ``strain`` more within ``duration``, day, at constant lateral stress ``cell_pressure``, kPa."""
    controls = (
        stress_value(cell_pressure, xx=1.0),
        stress_value(cell_pressure, yy=1.0),
        strain_change(strain, zz=1.0),
        *_no_shear(),
    )
    return Stage(f"drained triaxial to {strain:g}", duration, controls)


def undrained_triaxial(strain: float, duration: float) -> Stage:
    """Axial ``strain`` more within ``duration``, day, at constant volume and equal lateral strains."""
    controls = (
        strain_change(0.0, xx=1.0, yy=1.0, zz=1.0),
        strain_change(0.0, xx=1.0, yy=-1.0),
        strain_change(strain, zz=1.0),
        *_no_shear(),
    )
    return Stage(f"undrained triaxial to {strain:g}", duration, controls)


def simple_shear(gamma: float, axial_stress: float, duration: float) -> Stage:
    """Shear strain ``gamma`` more in the zx plane within ``duration``, day, under constant axial stress, kPa.

    No lateral strain. Small strain only: the axes turn with the shear.
    """
    controls = (
        *_no_lateral_strain(),
        stress_value(axial_stress, zz=1.0),
        strain_change(0.0, xy=1.0),
        strain_change(0.0, yz=1.0),
        strain_change(gamma, zx=1.0),
    )
    return Stage(f"simple shear to {gamma:g}", duration, controls)
