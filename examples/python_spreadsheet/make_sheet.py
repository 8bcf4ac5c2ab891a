"""Writes the spreadsheet of this example, settlement.fods.in: OpenDocument in one text file.

Only needed to change it; you can also save your own sheet as "Flat XML ODF Spreadsheet (.fods)", and put
the names of parameters in place of the numbers of some cells with a text editor.
"""

from __future__ import annotations

from pathlib import Path

LOADS = (10, 20, 30, 40, 60, 80, 100, 130, 160, 200)  # kPa
FIXED = {"thickness [m]": "4", "stress before [kPa]": "40", "void ratio": "1.1", "Cr": "0.05"}
FREE = {"Cc": "{{Cc}}", "preconsolidation stress [kPa]": "{{sigma_p}}"}
# B1 to B6 are the values above, A the load of the row
STRESS = "([.$B$2]+[.A{row}])"
FORMULA = (
    "of:=[.$B$1]/(1+[.$B$3])*([.$B$4]*LOG10(MIN({stress};[.$B$6])/[.$B$2])"
    "+[.$B$5]*LOG10(MAX({stress};[.$B$6])/[.$B$6]))"
)


def text(content: str) -> str:
    """Return a cell with text."""
    return f'<table:table-cell office:value-type="string"><text:p>{content}</text:p></table:table-cell>'


def value(content: str) -> str:
    """Return a cell with a number."""
    return f'<table:table-cell office:value-type="float" office:value="{content}"/>'


def sheet() -> str:
    """Return the template."""
    rows = [text(name) + value(given) for name, given in (FIXED | FREE).items()]
    rows.append(text("load [kPa]") + text("settlement [m]"))
    for row, load in enumerate(LOADS, start=len(rows) + 1):
        formula = FORMULA.format(stress=STRESS.format(row=row))
        rows.append(f'{value(str(load))}<table:table-cell table:formula="{formula}" office:value-type="float"/>')
    body = "\n".join(f"<table:table-row>{row}</table:table-row>" for row in rows)
    urn = "urn:oasis:names:tc:opendocument:xmlns"
    spaces = " ".join(f'xmlns:{name}="{urn}:{name}:1.0"' for name in ("office", "table", "text"))
    kind = 'office:mimetype="application/vnd.oasis.opendocument.spreadsheet"'
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<office:document {spaces} xmlns:of="{urn}:of:1.2" '
        f'office:version="1.2" {kind}>\n<office:body><office:spreadsheet>\n'
        f'<table:table table:name="settlement">\n{body}\n</table:table>\n'
        "</office:spreadsheet></office:body>\n</office:document>\n"
    )


if __name__ == "__main__":
    Path(__file__).with_name("settlement.fods.in").write_text(sheet(), encoding="utf-8")
