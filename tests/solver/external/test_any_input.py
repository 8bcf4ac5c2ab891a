"""Whatever a file holds, only the errors that are documented come out."""

from __future__ import annotations

import contextlib
import tempfile
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geoswarm.solver.external.errors import OutputError, TemplateError
from geoswarm.solver.external.inputs.pest_template import parse_pest_template
from geoswarm.solver.external.inputs.template import parse_template
from geoswarm.solver.external.outputs.pest.instructions import parse_instructions
from tests.solver.external.outputs.reading import reader_of

INSTRUCTIONS = "pif $\n$a$ w !h! t3 !dum!\nl1 [g]1:3 (f)2:4\n"
SECTIONS: dict[str, dict[str, Any]] = {
    "table": {"file": "a.txt", "x": 1, "y": "-column2"},
    "blocks": {"file": "a.txt", "x": "t", "y": 2, "each": "a(?P<t>.*)"},
    "search": {"file": "a.txt", "find": "(?P<x>.+) (?P<y>.*)"},
    "pest": {"file": "a.txt", "instructions": INSTRUCTIONS, "observations": {"h": 1, "g": 2}},
    "json": {"file": "a.json", "x": "a[*]", "y": "b[-1].c"},
    "npy": {"file": "a.npy", "x": 1, "y": 2},
    "npz": {"file": "a.npz", "x": "a", "y": "b"},
    "vtu": {"file": "a.vtu", "point": [0.5, 0.5], "field": "u"},
    "pvd": {"file": "a.pvd", "point": [0.5, 0.5], "field": "u"},
    "xdmf": {"file": "a.xdmf", "point": [0.5, 0.5], "field": "u"},
}
TEXT = st.lists(
    st.sampled_from(["a", "1.5 ", "\n", "2,", "{{", "}}", "!h!", " w", "l1 ", "$", "%", "[", '"', "{", ":"])
)

XDMF = """\
<Xdmf Version="3.0"><Domain><Grid Name="Grid"><Geometry GeometryType="XYZ">
<DataItem DataType="Float" Dimensions="4 3" Format="XML" Precision="8">0 0 0 1 0 0 1 1 0 0 1 0</DataItem></Geometry>
<Topology TopologyType="Quadrilateral" NumberOfElements="1" NodesPerElement="4">
<DataItem DataType="Int" Dimensions="1 4" Format="XML" Precision="8">0 1 2 3</DataItem></Topology>
<Attribute Name="u" AttributeType="Scalar" Center="Node">
<DataItem DataType="Float" Dimensions="4" Format="XML" Precision="8">1 1 1 1</DataItem></Attribute></Grid></Domain>
</Xdmf>
"""


def samples() -> dict[str, bytes]:
    """Sound files, to be spoilt."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        np.save(folder / "a.npy", np.ones((3, 2)))
        np.savez(folder / "a.npz", a=np.ones(3), b=np.ones(3))
        square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
        mesh = meshio.Mesh(square, [("quad", [[0, 1, 2, 3]])], point_data={"u": np.ones(4)})
        mesh.write(folder / "a.vtu", binary=False)
        (folder / "a.xdmf").write_text(XDMF, encoding="ascii")
        (folder / "a.pvd").write_bytes(
            b'<VTKFile><Collection><DataSet timestep="1" file="b.vtu"/></Collection></VTKFile>'
        )
        (folder / "a.txt").write_bytes(b"a 1 2\n1 2 3\n4 5 6\n\na 2 3\n")
        (folder / "a.json").write_bytes(b'{"a": [1, 2], "b": [{"c": [3, 4]}]}')
        return {path.name: path.read_bytes() for path in folder.iterdir()}


SAMPLES = samples()


@pytest.mark.parametrize("name", SECTIONS)
@settings(max_examples=40, deadline=None)
@given(st.data())
def test_readers_raise_output_errors_only(name: str, data: st.DataObject) -> None:
    section = SECTIONS[name]
    whole = SAMPLES[section["file"]]
    begin = data.draw(st.integers(0, len(whole)))
    end = data.draw(st.integers(begin, min(begin + 20, len(whole))))
    content = whole[:begin] + data.draw(st.binary(max_size=20)) + whole[end:]
    reader = reader_of(section)
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / section["file"]).write_bytes(content)
        try:
            x, y = reader.read(Path(folder))
        except OutputError as error:
            assert section["file"] in str(error) or "b.vtu" in str(error)  # noqa: PT017  both ways are right
            return
        assert len(x) == len(y) > 0
        assert np.isfinite(x).all()
        assert np.isfinite(y).all()


@given(TEXT)
def test_templates_raise_template_errors_only(pieces: list[str]) -> None:
    text = "".join(pieces)
    with contextlib.suppress(TemplateError):
        assert parse_template(text, "a").file == "a"
    with contextlib.suppress(TemplateError):
        assert parse_pest_template(f"ptf %\n{text}", "a").file == "a"
    with contextlib.suppress(TemplateError):
        assert parse_instructions(f"pif $\n{text}", "a").file == "a"
