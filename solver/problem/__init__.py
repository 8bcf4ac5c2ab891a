"""What a user asks for: the problem file of YAML or JSON, checked and ready to be calibrated.

=======================  =============================================================================================
``assembly``             from a document to a checked problem: first each section on its own, so that all mistakes are
                         reported together
``checks``               what is found wrong, or worth telling, in a problem that can be read
``draft``                a draft of a problem: its mistakes by line, and parameters and series of its forward model so
                         far
``given``                values of all parameters from given ones
``issues``               turns what pydantic finds wrong into issues in plain words, each with its path in the problem
                         file
``load_stages``          the load stages of a test, from a column of loads beside the readings
``observation_section``  the section of one observation: its readings or their file, and how they are processed
``observations``         observations: measured points of a series, checked against the series and converted to base
                         units
``parameters``           parameters of a problem: free, fixed or linked; their names, limits and order of evaluation
``points``               measured points of an observation's section, inside the problem or in a file, prepared as the
                         section says
``problem``              a checked problem, ready to be calibrated
``questions``            the questions that a file leaves open: its columns and their units, with an answer to copy; the
                         sign of a heave
``readings``             what becomes of the readings of an observation: blocks joined, processed, and which of them
                         take part
``running``              the sections of a problem file on running its evaluations: limits, and what happens when one
                         fails
``schema``               the JSON schema of the problem file, with the section of every installed forward model
``sections``             the sections of a problem file as pydantic models: names, types, limits and defaults of
                         everything written in it
``stages``               when the loads of a test in stages are applied, for what runs over the time of such a test
``test_table``           a table of laboratory tests, one row a test, which becomes parts and observations of a combined
                         problem
``tables``               measurements from tables: CSV, workbooks, pasted cells
``text``                 the text of a problem: YAML and JSON, read and written
``weighting``            weights w_g of the series that follow from their readings, and the shares of series and tests
                         in the objective
=======================  =============================================================================================
"""

from geoswarm.solver.problem.assembly import load_problem, parse_problem
from geoswarm.solver.problem.draft import Draft, LocatedIssue, draft_of_document, draft_of_text
from geoswarm.solver.problem.load_stages import measured_stages
from geoswarm.solver.problem.observations import Observation
from geoswarm.solver.problem.parameters import FixedParameter, FreeParameter, LinkedParameter, Parameter
from geoswarm.solver.problem.points import Points, measured_points
from geoswarm.solver.problem.problem import Problem
from geoswarm.solver.problem.schema import problem_schema
from geoswarm.solver.problem.sections import Stopping
from geoswarm.solver.problem.tables.measurements import Measurements, read_measurements
from geoswarm.solver.problem.tables.reading import MAX_TABLE_BYTES, TableError
from geoswarm.solver.problem.text.reading import MAX_BYTES, read_document
from geoswarm.solver.problem.text.writing import problem_yaml

__all__ = [
    "MAX_BYTES",
    "MAX_TABLE_BYTES",
    "Draft",
    "FixedParameter",
    "FreeParameter",
    "LinkedParameter",
    "LocatedIssue",
    "Measurements",
    "Observation",
    "Parameter",
    "Points",
    "Problem",
    "Stopping",
    "TableError",
    "draft_of_document",
    "draft_of_text",
    "load_problem",
    "measured_points",
    "measured_stages",
    "parse_problem",
    "problem_schema",
    "problem_yaml",
    "read_document",
    "read_measurements",
]
