"""Writes the meshes of this example, VTU files in text: a column of 5 m of eight-node rectangles, and its four sides.

Only needed to change them; they are kept beside it.
"""

from __future__ import annotations

from pathlib import Path

HEIGHT, WIDTH = 5.0, 0.5  # m
ROWS = 20
QUAD8, LINE3 = 23, 21  # types of VTK


def write(
    path: Path, points: list[tuple[float, float]], cells: list[list[int]], kind: int, bulk: list[list[int]]
) -> None:
    """Write a mesh; ``bulk``: numbers of its nodes and elements in the whole mesh, for sides."""
    names = (("PointData", "bulk_node_ids"), ("CellData", "bulk_element_ids"))
    data = [
        f'<{tag}>\n<DataArray type="UInt64" Name="{name}" format="ascii">\n'
        f"{' '.join(map(str, ids))}\n</DataArray>\n</{tag}>"
        for (tag, name), ids in zip(names, bulk, strict=False)
    ]
    offsets = [sum(map(len, cells[: i + 1])) for i in range(len(cells))]
    arrays = {
        "connectivity": ("Int64", (str(node) for cell in cells for node in cell)),
        "offsets": ("Int64", map(str, offsets)),
        "types": ("UInt8", (str(kind) for _ in cells)),
    }
    listed = "\n".join(
        f'<DataArray type="{of}" Name="{name}" format="ascii">\n{" ".join(values)}\n</DataArray>'
        for name, (of, values) in arrays.items()
    )
    coordinates = "\n".join(f"{x:.10g} {y:.10g} 0" for x, y in points)
    path.write_text(
        '<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian">\n'
        f'<UnstructuredGrid>\n<Piece NumberOfPoints="{len(points)}" NumberOfCells="{len(cells)}">\n'
        + "\n".join(data)
        + '\n<Points>\n<DataArray type="Float64" Name="Points" NumberOfComponents="3" format="ascii">\n'
        f"{coordinates}\n</DataArray>\n</Points>\n<Cells>\n{listed}\n</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n",
        encoding="utf-8",
    )


def main(folder: Path) -> None:
    """Write all five into a folder."""
    # finer to the top, where water leaves
    heights = [HEIGHT * (1.0 - (1.0 - i / ROWS) ** 1.5) for i in range(ROWS + 1)]
    nodes: dict[tuple[float, float], int] = {}

    def node(x: float, y: float) -> int:
        return nodes.setdefault((x, y), len(nodes))

    corners = [[node(x, y) for x in (0.0, WIDTH)] for y in heights]  # corners first, as OpenGeoSys wants them
    cells = []
    for i in range(ROWS):
        low, high = heights[i], heights[i + 1]
        middle = 0.5 * (low + high)
        bottom, right = node(WIDTH / 2, low), node(WIDTH, middle)
        top, left = node(WIDTH / 2, high), node(0.0, middle)
        cells.append([*corners[i], *corners[i + 1][::-1], bottom, right, top, left])
    points = list(nodes)
    write(folder / "column.vtu", points, cells, QUAD8, [])
    edges = {"bottom": (0, 1, 4), "right": (1, 2, 5), "top": (2, 3, 6), "left": (3, 0, 7)}
    rows = {"bottom": [0], "right": range(ROWS), "top": [ROWS - 1], "left": range(ROWS)}
    for side, edge in edges.items():
        lines = [[cells[row][local] for local in edge] for row in rows[side]]
        used = sorted({number for line in lines for number in line})
        own = {number: index for index, number in enumerate(used)}
        numbered = [[own[number] for number in line] for line in lines]
        write(folder / f"{side}.vtu", [points[number] for number in used], numbered, LINE3, [used, list(rows[side])])


if __name__ == "__main__":
    main(Path(__file__).resolve().parent)
