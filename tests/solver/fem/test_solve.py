"""Phases: regions come and go, materials change, loads are in balance, and failures say why."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from geoswarm.solver.constitutive.soft_soil_creep.physics import soft_soil_creep
from geoswarm.solver.errors import DivergedError
from geoswarm.solver.fem.initial import stress_at_rest
from geoswarm.solver.fem.materials import InterfaceMaterial
from geoswarm.solver.fem.mesh.mesh import Mesh
from geoswarm.solver.fem.phases import Control, Fixity, Phase, Traction
from geoswarm.solver.fem.solve import Calculation, solve_phases
from geoswarm.solver.laws.soft_soil_creep import equivalent_pressures
from geoswarm.verification.specimens.bodies import block, embankment, graded, moved, node_at, stacked
from geoswarm.verification.specimens.soils import creeping, elastic, mohr_coulomb

SOIL = elastic(1.0e4, 0.3, 20.0)
BOX = (Fixity("left", x=0.0), Fixity("right", x=0.0), Fixity("bottom", x=0.0, y=0.0))
TIGHT = Control(tolerance=1.0e-10)


def _column() -> Mesh:
    return block(graded(0.0, 1.0, 1), graded(0.0, 4.0, 4))


def _layers() -> Mesh:
    lower = block(graded(0.0, 1.0, 1), graded(0.0, 2.0, 2), name="lower")
    upper = moved(block(graded(0.0, 1.0, 1), graded(0.0, 2.0, 2), name="upper"), lambda x: x + np.array([0.0, 2.0]))
    return stacked(lower, upper)


LAYERS_HELD = (
    Fixity("left", x=0.0),
    Fixity("right", x=0.0),
    Fixity("lower left", x=0.0),
    Fixity("lower right", x=0.0),
    Fixity("lower bottom", y=0.0),
)


def test_gravity_gives_the_weight_to_the_bottom() -> None:
    mesh = _column()
    result = solve_phases(mesh, [Phase("weight", "gravity", materials={"soil": SOIL}, fixities=BOX)], control=TIGHT)[0]
    assert result.reactions[:, 1].sum() == pytest.approx(80.0, rel=1.0e-9)
    top = node_at(mesh, 0.0, 4.0)
    modulus = 1.0e4 * 0.7 / (1.3 * 0.4)
    assert result.displacements[top, 1] == pytest.approx(-20.0 * 16.0 / 2.0 / modulus, rel=1.0e-2)


def test_stress_at_rest_is_in_balance_with_the_weight() -> None:
    mesh = _column()
    phases = [
        Phase("rest", "K0", materials={"soil": replace(SOIL, K0=0.6)}, fixities=BOX, surcharge=5.0),
        Phase("nothing", tractions=(Traction("top", y=-5.0),)),
    ]
    rest, after = solve_phases(mesh, phases, control=TIGHT)
    points = np.einsum("pn,enj->epj", np.array([[1, 0, 0]] * 3), mesh.nodes[mesh.triangles[:, :3]])
    assert points.shape == (8, 3, 2)
    assert rest.stress[..., 0] == pytest.approx(0.6 * rest.stress[..., 1])
    assert np.abs(after.displacements).max() < 1.0e-9
    assert after.stress == pytest.approx(rest.stress, abs=1.0e-6)


def test_vertical_stress_is_the_weight_above_in_layers() -> None:
    mesh = _layers()
    weight = np.where(mesh.regions == 0, 18.0, 10.0)
    stress = stress_at_rest(mesh, mesh.nodes, weight, np.full(weight.size, 0.5), 3.0)
    heights = np.einsum("pn,en->ep", np.array([[2, 2, -1]]) / 3.0, mesh.nodes[mesh.triangles[:, :3], 1])
    assert heights.shape == (8, 1)
    deepest = stress[mesh.regions == 0, :, 1].min()
    assert -(3.0 + 20.0 + 36.0) < deepest < -(3.0 + 20.0 + 30.0)
    assert stress[mesh.regions == 1, :, 1].max() > -(3.0 + 10.0)


def test_a_region_is_placed_and_taken_away_again() -> None:
    mesh = _layers()
    joint = InterfaceMaterial(1.0e6, 1.0e6, 0.0, 30.0)
    phases = [
        Phase("ground", "gravity", {"lower": SOIL}, active=frozenset({"lower"}), fixities=LAYERS_HELD),
        Phase("fill", materials={"upper": SOIL, "joint": joint}, active=frozenset({"lower", "upper", "joint"})),
        Phase("cut", active=frozenset({"lower"})),
    ]
    ground, fill, cut = solve_phases(mesh, phases, control=TIGHT)
    assert ground.reactions[:, 1].sum() == pytest.approx(40.0)
    assert fill.reactions[:, 1].sum() == pytest.approx(80.0)
    assert fill.interface_tractions[..., 0] == pytest.approx(-40.0, abs=1.0e-6)
    assert cut.reactions[:, 1].sum() == pytest.approx(40.0)
    assert cut.stress[mesh.regions == 1] == pytest.approx(0.0)
    assert cut.stress[mesh.regions == 0] == pytest.approx(ground.stress[mesh.regions == 0], abs=1.0e-6)


def test_a_material_that_creeps_is_consolidated_by_the_stress_it_finds() -> None:
    mesh = _column()
    constants = soft_soil_creep(0.1, 0.02, 0.002, 5.0, 25.0)
    clay = creeping(constants, 20.0, OCR=1.05)
    phases = [
        Phase("weight", "gravity", materials={"soil": SOIL}, fixities=BOX),
        Phase("creep", "creep", materials={"soil": clay}, duration=100.0, reset_displacements=True),
    ]
    calculation = Calculation(mesh, observe=[node_at(mesh, 0.0, 4.0)])
    weight = calculation.run(phases[0])
    creep = calculation.run(phases[1])
    expected = 1.05 * equivalent_pressures(-weight.stress, constants)
    assert (creep.internal[..., 0] > np.log(expected) - 1.0e-12).all()
    assert creep.history.times[0] == 0.0
    assert creep.history.times[-1] == 100.0
    settlement = -creep.history.displacements[:, 0, 1]
    assert settlement[0] == 0.0
    assert (np.diff(settlement) > 0.0).all()


def test_a_ramp_ends_where_its_instant_load_and_rest_would_for_an_elastic_body() -> None:
    mesh = _column()
    load = (Traction("top", normal=-10.0),)
    base = Phase("load", "creep", {"soil": elastic(1.0e4, 0.3)}, None, BOX, load, duration=10.0)
    at_once = solve_phases(mesh, [replace(base, output_times=(0.0, 10.0))], observe=[0, 4])[0]
    ramp = solve_phases(mesh, [replace(base, instant=False, output_times=(0.0, 5.0, 10.0))], observe=[0, 4])[0]
    assert ramp.displacements == pytest.approx(at_once.displacements, abs=1.0e-9)
    assert ramp.history.displacements[1] == pytest.approx(0.5 * ramp.history.displacements[2], abs=1.0e-9)
    assert at_once.history.displacements[0] == pytest.approx(at_once.history.displacements[1], abs=1.0e-9)


def test_modified_newton_finds_the_same_solution() -> None:
    mesh = block(graded(0.0, 4.0, 6), graded(0.0, 2.0, 4))
    soil = mohr_coulomb(1.0e4, 0.3, 18.0, 25.0, unit_weight=20.0)
    load = (Traction("top", normal=-30.0, x_slope=0.0),)
    phase = Phase(
        "load", "gravity", {"soil": soil}, None, (Fixity("bottom", x=0.0, y=0.0), Fixity("left", x=0.0)), load
    )
    strict = Control(tolerance=1.0e-9, load_tolerance=0.0)
    full = solve_phases(mesh, [phase], control=strict)[0]
    modified = solve_phases(mesh, [phase], control=replace(strict, modified=True, iterations=60))[0]
    assert full.plastic.any()
    assert modified.displacements == pytest.approx(full.displacements, abs=1.0e-8)
    assert modified.factorisations < modified.iterations


def test_a_load_without_balance_at_its_end_is_approached_again_more_strictly() -> None:
    mesh = embankment(12.0, 20, 10)  # carries its weight with its strength reduced by up to 1.38
    soil = mohr_coulomb(1.0e5, 0.3, 10.0 / 1.37, 14.8782, tension_cutoff=None, unit_weight=20.0)
    phase = Phase("weight", "gravity", {"soil": soil}, fixities=BOX[::2], load_step=0.2)
    loose = solve_phases(mesh, [phase], control=Control(tolerance=1.0e-4))[0]
    strict = solve_phases(mesh, [phase], control=Control(tolerance=1.0e-4, load_tolerance=0.003))[0]
    assert loose.steps > strict.steps
    assert loose.displacements == pytest.approx(strict.displacements, abs=1.0e-12)
    assert np.array_equal(loose.history.times, strict.history.times)


def test_too_much_load_says_which_phase_how_far_and_why() -> None:
    mesh = block(graded(0.0, 2.0, 4), graded(0.0, 1.0, 2))
    soil = mohr_coulomb(1.0e4, 0.3, 5.0, 0.0)
    phase = Phase(
        "crush",
        materials={"soil": soil},
        fixities=(Fixity("bottom", y=0.0), Fixity("left", x=0.0)),
        tractions=(Traction("top", normal=-20.0),),
    )
    with pytest.raises(DivergedError) as failure:
        solve_phases(mesh, [phase])
    assert failure.value.reason == "diverged"
    assert str(failure.value).startswith("phase 'crush': no equilibrium beyond 0.")
    share = float(str(failure.value).split("beyond ")[1].split(" of")[0])
    assert share == pytest.approx(0.5, abs=0.01)


def test_the_work_of_a_phase_is_bounded() -> None:
    mesh = block(graded(0.0, 2.0, 4), graded(0.0, 1.0, 2))
    phase = Phase(
        "crush",
        materials={"soil": mohr_coulomb(1.0e4, 0.3, 5.0, 0.0)},
        fixities=(Fixity("bottom", y=0.0), Fixity("left", x=0.0)),
        tractions=(Traction("top", normal=-20.0),),
    )
    with pytest.raises(DivergedError) as failure:
        solve_phases(mesh, [phase], control=Control(largest_assemblies=60))
    assert str(failure.value).startswith("phase 'crush': no equilibrium beyond 0.")
    assert "more than 60 assemblies of the balance are needed: Newton's method does not converge" in str(failure.value)


def test_a_crack_that_opened_closes_before_it_presses() -> None:
    """The upper layer is lifted by 10 mm, set down half of that, then pressed by 1 mm beyond where it stood."""
    mesh = _layers()
    joint = InterfaceMaterial(1.0e5, 1.0e5, 0.0, 30.0)
    stiff = elastic(1.0e7, 0.0)

    def moved_by(distance: float) -> Phase:
        held = (Fixity("lower bottom", x=0.0, y=0.0), Fixity("top", x=0.0, y=distance))
        return Phase(f"{distance:g}", materials={"lower": stiff, "upper": stiff, "joint": joint}, fixities=held)

    lifted, lowered, pressed = solve_phases(mesh, [moved_by(0.01), moved_by(-0.005), moved_by(-0.006)])
    assert np.abs(lifted.interface_tractions).max() < 1.0e-9
    assert np.abs(lowered.interface_tractions).max() < 1.0e-9
    # 1 mm shared by two layers of 2 m in series with the interface.
    expected = 0.001 / (4.0 / 1.0e7 + 1.0 / 1.0e5)
    assert pressed.interface_tractions[..., 0] == pytest.approx(-expected, rel=1.0e-3)


def test_a_body_that_is_not_held_is_singular() -> None:
    phase = Phase("loose", materials={"soil": SOIL}, tractions=(Traction("top", normal=-1.0),))
    with pytest.raises(DivergedError, match="loose"):
        solve_phases(_column(), [phase])


@pytest.mark.parametrize(
    ("phase", "message"),
    [
        (Phase("p", materials={"clay": SOIL}), "phase 'p': 'clay' is not a region or interface; known: soil"),
        (Phase("p"), "region 'soil' has no soil material"),
        (Phase("p", materials={"soil": SOIL}, fixities=(Fixity("base", x=0.0),)), "'base' is neither a boundary"),
        (Phase("p", materials={"soil": SOIL}, tractions=(Traction("roof"),)), "traction on 'roof'"),
        (
            Phase("p", "creep", {"soil": SOIL}, fixities=BOX, duration=1.0, output_times=(2.0,)),
            "output_times must increase from 0 to 1 day",
        ),
    ],
)
def test_what_the_mesh_does_not_know_is_named(phase: Phase, message: str) -> None:
    with pytest.raises(ValueError, match=r".+") as failure:
        solve_phases(_column(), [phase])
    assert message in str(failure.value)


def test_an_unknown_point_is_named() -> None:
    with pytest.raises(ValueError, match="point 'A' is not in the mesh; known: none"):
        solve_phases(_column(), [], observe=["A"])
