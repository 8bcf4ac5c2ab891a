"""The one list of all blocks of the documentation: the test that runs or checks each, or why none does.

A block is named by words that it alone contains on its page, or by its kind for all of that kind. Behind it stands the
test, ``tests/....py::test_name``, or a sentence that says why it is not run. Calls of ``geoswarm``, targets of make and
files of the repository that any block names are held against what there is (test_commands.py), and bash reads every
block of a shell.
"""

from __future__ import annotations

from typing import Final

__all__ = ["BLOCKS"]

HERE = "tests/documentation/"
COMMANDS = f"{HERE}test_command_pages.py::"
SERVICE = f"{HERE}test_service_pages.py::"
PROBLEMS = f"{HERE}test_problem_blocks.py::"
PYTHON = f"{HERE}test_python_blocks.py::"
START = f"{HERE}test_quick_start.py::"
CONFIGURATION = f"{HERE}test_configurations.py::"
EXAMPLE = f"{HERE}test_example_pages.py::test_longer_ones_run"
DIAGRAMS = "tests/contracts/test_site.py::test_diagrams_have_the_pictures_of_their_text"
TUTORIAL = "tests/tutorials/test_tutorials.py::test_a_tutorial_runs_from_its_first_line_to_its_last"
PEST = "tests/solver/external/pest_control/test_page.py::"
UMBRIDGE = "tests/geoswarm/cli/test_umbridge.py::test_the_example_of_the_page_runs_both_ways_with_the_package"
PLUG_IN = "tests/geoswarm/test_plug_ins.py::test_its_problem_is_calibrated"
CLIENT = "tests/geoswarm/client/test_documentation.py::test_examples_of_the_client_run"

EQUATIONS = "Equations of the law in plain text, which its tests in tests/solver and tests/verification work out."
DRAWING = "A drawing of the test in letters, for the eye."
INDEX = "It installs for the reader; tests/contracts/test_installation.py installs the same from a wheel."
MAKE = "It installs the development environment or runs these very tests; its targets are looked up in the Makefile."

BLOCKS: Final[dict[str, dict[str, str]]] = {
    "CONTRIBUTING.md": {"make setup": MAKE},
    "README.md": {
        "make demo": MAKE,
        "λ*  0.0825": f"{START}test_the_verdicts_of_the_readme_are_those_of_the_example",
        "geoswarm examples oedometer": f"{START}test_its_commands_run",
        "pip install": INDEX,
        "name: oedometer-san-cassiano": f"{PROBLEMS}test_the_problem_of_the_readme_is_valid",
        "mermaid": DIAGRAMS,
    },
    "deploy/kubernetes/README.md": {
        "kubectl create namespace": (
            "It needs a cluster; tests/deployment/test_kubernetes.py compares the keys of the secret."
        ),
        "rules:": f"{CONFIGURATION}test_the_rule_of_the_adapter_has_the_metrics_of_the_service",
        "delete hpa": (
            "It needs a cluster; the names are those of the manifests in tests/deployment/test_kubernetes.py."
        ),
    },
    "docs/agents.md": {
        "geoswarm keys create": f"{SERVICE}test_keys_are_made_and_revoked",
        "geoswarm agent --server https://calibration.example.org --models ~": (
            "It runs until it is stopped, against a server elsewhere; tests/deployment/test_agent_over_tls.py runs it."
        ),
        "geoswarm models sign": (
            "Service and agent run until they are stopped; tests/integration/test_agents.py runs all three."
        ),
        "proxy_pass": f"{CONFIGURATION}test_nginx_accepts_the_proxy",
        "sbatch": "It needs a cluster with Slurm; tests/deployment/test_slurm.py runs the script of the array.",
        "powershell": "It is for Windows; its call of geoswarm is held against the command line.",
    },
    "docs/ags.md": {
        "geoswarm import ags": f"{COMMANDS}test_a_file_of_a_laboratory_is_imported",
        "data.ags line 41": f"{COMMANDS}test_a_file_of_a_laboratory_is_imported",
    },
    "docs/column.md": {"indented": EQUATIONS},
    "docs/command-line.md": {
        "geoswarm inline": f"{SERVICE}test_jobs_over_http",
        "geoswarm evaluate": f"{COMMANDS}test_a_single_calculation_prints_what_the_page_shows",
        '{"state", ': f"{COMMANDS}test_a_run_prints_the_members_that_the_page_lists",
        "geoswarm verify": f"{COMMANDS}test_a_verification_prints_what_the_page_shows",
    },
    "docs/decisions/0001-layout.md": {"indented": "It lists the rooms; import-linter enforces them."},
    "docs/decisions/0021-inner-rooms.md": {"indented": "It lists the inner rooms; import-linter enforces them."},
    "docs/engine.md": {"mermaid": DIAGRAMS},
    "docs/finite-elements.md": {
        "two axisymmetric triangles": f"{PROBLEMS}test_a_specimen_of_finite_elements_is_calculated",
        "kind: section": f"{PROBLEMS}test_the_section_with_its_phases_is_calculated",
        "- name: weight": f"{PROBLEMS}test_the_section_with_its_phases_is_calculated",
        "kind: finite_element": f"{PROBLEMS}test_a_mesh_of_ones_own_is_calculated",
        "write_pvd": f"{PYTHON}test_results_for_paraview",
    },
    "docs/http-api.md": {
        "--data @problem.json": f"{SERVICE}test_jobs_over_http",
        "specimen.jpg": f"{SERVICE}test_a_file_is_attached_as_the_page_shows",
        "numpy.frombuffer": f"{SERVICE}test_points_are_read_as_the_page_does",
        "event: generation": f"{SERVICE}test_events_have_the_form_and_members_of_the_page",
        "urn:geoswarm:error": f"{SERVICE}test_a_mistake_is_answered_as_the_page_shows",
    },
    "docs/index-properties.md": {
        "geoswarm estimate": f"{COMMANDS}test_estimates_of_a_problem_without_parameters",
        "liquid_limit": f"{PROBLEMS}test_a_section_is_accepted",
    },
    "docs/laboratory-files.md": {
        "sheet: Oedometer 1": f"{PROBLEMS}test_keys_of_a_file_of_a_laboratory_are_those_of_an_observation",
        "blocks:": f"{PROBLEMS}test_keys_of_a_file_of_a_laboratory_are_those_of_an_observation",
        "name;  file;": f"{PROBLEMS}test_the_table_of_tests_is_read",
        "name: karlsruhe-sand": f"{PROBLEMS}test_the_table_of_tests_is_read",
    },
    "docs/laboratory-tests.md": {"indented": DRAWING},
    **{
        f"docs/laws/{law}.md": {"indented": EQUATIONS}
        for law in (
            *("drucker-prager", "hardening-soil", "hardening-soil-small", "hypoplastic-clay", "hypoplastic-sand"),
            *("matsuoka-nakai", "modified-cam-clay", "mohr-coulomb", "soft-soil", "soft-soil-creep"),
        )
    },
    "docs/operations.md": {
        "docker compose": (
            "It builds images; "
            "tests/deployment/test_image.py replays the image, tests/contracts/test_compose.py reads the rest."
        ),
        "connections - 3": (
            "tests/contracts/test_compose.py::"
            "test_the_database_admits_the_connections_of_the_workers_that_the_documentation_promises"
        ),
        "geoswarm prune": f"{SERVICE}test_jobs_that_ended_long_ago_are_pruned",
    },
    "docs/pest.md": {
        "text": f"{PEST}test_the_example_of_the_page_runs",
        "sh": f"{PEST}test_the_example_of_the_page_runs",
        "yaml": f"{PEST}test_the_example_of_the_page_runs",
    },
    "docs/plug-ins.md": {
        "[build-system]": PLUG_IN,
        "class TerzaghiSpec": PLUG_IN,
        "name: clay-layer": PLUG_IN,
        "@NumbaUpdate": "tests/solver/laws/test_laws.py::test_the_update_of_the_documentation_is_elasticity",
    },
    "docs/prediction.md": dict.fromkeys(
        (
            *("geoswarm predict", "name: stage at 1600 kPa", "client.predict"),
            *("geoswarm design", "candidates:\n", "client.design"),
        ),
        f"{PYTHON}test_predictions_and_candidate_tests",
    )
    | {"name: twenty further tests": f"{PROBLEMS}test_the_table_of_tests_is_read"},
    "docs/problem-file.md": {
        "name: oedometer-san-cassiano": f"{PROBLEMS}test_the_first_problem_of_the_reference_is_the_example",
        "answer: {": f"{PROBLEMS}test_a_section_is_accepted",
        "limits: {": f"{PROBLEMS}test_a_section_is_accepted",
        "failures:": f"{PROBLEMS}test_a_section_is_accepted",
        "index_properties:": f"{PROBLEMS}test_a_section_is_accepted",
        "kind: crs_oedometer": f"{PROBLEMS}test_a_laboratory_test_of_the_reference_is_calculated",
        "kind: consolidation\n": f"{PROBLEMS}test_a_laboratory_test_of_the_reference_is_calculated",
        "kind: triaxial": f"{PROBLEMS}test_a_laboratory_test_of_the_reference_is_calculated",
        "kind: direct_simple_shear": f"{PROBLEMS}test_a_laboratory_test_of_the_reference_is_calculated",
    },
    "docs/programs.md": {
        "geoswarm model new": f"{COMMANDS}test_a_program_becomes_a_forward_model",
        "geoswarm model try": f"{COMMANDS}test_a_program_becomes_a_forward_model",
        "link: [mesh.inc]": f"{COMMANDS}test_the_section_of_a_program_reads_what_it_says",
        "title: Footing": f"{COMMANDS}test_a_registered_model_is_listed_tried_and_shown",
        "geoswarm models": f"{COMMANDS}test_a_registered_model_is_listed_tried_and_shown",
    },
    "docs/python-client.md": {
        "python": CLIENT,
        "text": f"{CONFIGURATION}test_errors_of_the_client_are_drawn_as_they_descend",
    },
    "docs/python.md": {
        "python": "tests/geoswarm/test_python_page.py::test_examples_of_the_page_run",
        "kind: python": f"{PROBLEMS}test_a_function_in_a_problem_file_is_calculated",
    },
    "docs/quick-start.md": {
        "pip install": INDEX,
        "geoswarm examples oedometer": f"{START}test_the_quick_start_types_what_the_readme_types",
        "from geoswarm import Client": f"{START}test_its_python_runs_with_the_service",
        "gs.calibrate(": f"{START}test_its_python_runs_without_one",
    },
    "docs/releasing.md": {
        "gh attestation": (
            "It asks GitHub and the package index for a release; "
            "tests/contracts/test_release.py checks how one is made."
        )
    },
    "docs/report.md": {
        "geoswarm report latest": f"{SERVICE}test_reports_and_follow_ups_of_a_job",
        "client.reweight": f"{SERVICE}test_reports_and_follow_ups_of_a_job",
        "client.posterior": f"{SERVICE}test_reports_and_follow_ups_of_a_job",
    },
    "docs/security.md": {"geoswarm keys create": f"{SERVICE}test_keys_are_made_and_revoked"},
    "docs/statistics.md": {
        "verdict.sentence": f"{PYTHON}test_verdicts_from_python",
        "f <= f0": "An equation, which tests/solver/identifiability works out.",
    },
    **{
        f"docs/tutorials/{name}.md": dict.fromkeys(kinds, TUTORIAL)
        for name, kinds in {
            "embankment": ("bash", "text"),
            "first-oedometer": ("csv", "yaml", "bash", "text"),
            "own-program": ("bash", "text"),
            "python-function": ("python", "text"),
            "triaxial-series": ("bash", "text"),
            "two-tests": ("bash", "yaml", "text"),
            "what-can-the-test-tell": ("bash", "text"),
            "creeping-slope": ("csv", "bash", "text"),
            "reading-a-report": ("bash", "python", "text"),
            "service-with-agents": ("bash", "python", "text"),
        }.items()
    },
    "docs/umbridge.md": {"python": UMBRIDGE, "yaml": UMBRIDGE, "sh": UMBRIDGE},
    "docs/user-laws.md": {
        "geoswarm model build-umat": f"{COMMANDS}test_a_soil_law_in_fortran",
        "library: libsand.so      ": f"{COMMANDS}test_a_soil_law_in_fortran",
        "law: mfront": (
            "tests/verification/test_mfront_laws.py::test_the_example_of_the_page_compresses_along_its_lines"
        ),
        "title: Oedometer with our sand": f"{COMMANDS}test_a_registered_model_with_a_law_of_its_own",
    },
    "docs/watching.md": {
        "geoswarm hooks": f"{SERVICE}test_hooks_are_made_tried_and_removed",
        "POST /hook": f"{SERVICE}test_hooks_are_made_tried_and_removed",
        "from standardwebhooks": (
            "A receiver's code with a package of others; "
            "tests/workers/notices/test_web.py holds our signature against theirs."
        ),
    },
    **{
        f"examples/{name}/README.md": {"indented": EXAMPLE}
        for name in (
            *("calculix", "column", "combined", "consolidation", "crs_oedometer", "direct_simple_shear"),
            *("fortran_pest", "isotropic_compression", "oedometer", "pile_tz", "triaxial", "umat"),
        )
    },
    "examples/formula/README.md": {"indented": f"{HERE}test_example_pages.py::test_the_quick_one_runs"},
    "examples/plaxis/README.md": {
        "indented": (
            "It needs PLAXIS, which cannot be had; tests/examples/test_plaxis.py drives the script against a stand-in."
        )
    },
    "examples/kratos/README.md": {
        "indented": (
            "It installs from the package index; tests/examples/test_kratos.py runs and examines the same problem."
        )
    },
    "examples/opengeosys/README.md": {
        "indented": (
            "It installs from the package index; tests/examples/test_opengeosys.py runs and examines the same problem."
        )
    },
    "examples/opengeosys_slope/README.md": {
        "indented": (
            "It installs from the package index; "
            "tests/examples/test_opengeosys_slope.py runs and examines both problems."
        )
    },
    "examples/python_spreadsheet/README.md": {
        "indented": (
            "It needs LibreOffice; tests/examples/test_python_spreadsheet.py runs and examines the same problem."
        )
    },
    "examples/slope/README.md": {
        "indented": (
            "Its search takes an hour; tests/examples/test_slope.py calculates its published sets of parameters."
        )
    },
}
