"""A SYNTHETIC file in the AGS 4 format: no ground investigation stands behind its numbers, they are closed forms."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

E0, START = 1.2, 1.2
CC, CS, PAST = 0.5, 0.06, 80.0
STRESSES = (12.0, 25.0, 50.0, 100.0, 200.0, 400.0, 800.0, 200.0, 50.0)
COHESION, PHI = 5.0, 28.0

KEYS = ("LOCA_ID", "SAMP_TOP", "SAMP_REF", "SAMP_TYPE", "SAMP_ID", "SPEC_REF", "SPEC_DPTH")
KEY_UNITS = ("", "m", "", "", "", "", "m")


def void_ratio(stresses: Sequence[float], past: float = PAST, e0: float = E0) -> list[float]:
    """Void ratios of two straight lines over log10(stress), Cs below the largest stress so far and Cc on it."""
    found, e, now, largest = [], e0, START, past
    for stress in stresses:
        e -= CS * math.log10(min(stress, largest) / min(now, largest))
        if stress > largest:
            e -= CC * math.log10(stress / largest)
        largest, now = max(largest, stress), stress
        found.append(e)
    return found


def deviator(third: float) -> float:
    """q at failure for c' and phi'."""
    sine, cosine = math.sin(math.radians(PHI)), math.cos(math.radians(PHI))
    return 2.0 * (COHESION * cosine + third * sine) / (1.0 - sine)


def group(name: str, columns: Mapping[str, tuple[str, str]], rows: Sequence[Sequence[object]]) -> str:
    """Text of a group: unit and type by heading, and rows of cells."""
    lines = [["GROUP", name], ["HEADING", *columns]]
    lines.append(["UNIT", *(unit for unit, _ in columns.values())])
    lines.append(["TYPE", *(kind for _, kind in columns.values())])
    lines += [["DATA", *(cell if isinstance(cell, str) else f"{cell:.12g}" for cell in row)] for row in rows]
    return "".join(",".join('"' + cell.replace('"', '""') + '"' for cell in line) + "\r\n" for line in lines) + "\r\n"


def keyed(**columns: tuple[str, str]) -> dict[str, tuple[str, str]]:
    """Columns behind those that say which specimen it is."""
    return {**{key: (unit, "X") for key, unit in zip(KEYS, KEY_UNITS, strict=True)}, **columns}


FIRST = ("BH1", "4.50", "3", "U", "", "1", "4.60")
SECOND = ("BH2", "6.00", "5", "U", "", "1", "6.10")
SWELLING = ("BH2", "9.00", "7", "U", "", "1", "9.05")
DRAINED = ("BH1", "4.50", "3", "U", "", "2", "4.70")
UNDRAINED = ("BH2", "6.00", "5", "U", "", "2", "6.20")
QUICK = ("BH2", "9.00", "7", "U", "", "3", "9.10")


def compression(specimen: Sequence[str], past: float, e0: float) -> list[list[object]]:
    """Rows of CONS."""
    ends = void_ratio(STRESSES, past, e0)
    starts = [e0, *ends]
    return [
        [*specimen, str(n), start, stress, end]
        for n, (start, stress, end) in enumerate(zip(starts, STRESSES, ends, strict=False), start=1)
    ]


def groups() -> dict[str, str]:
    """The groups by name."""
    drained = [
        [*DRAINED, str(n), third, third + 200.0, 200.0, "", 4.0 + n, deviator(third), 1.5]
        for n, third in enumerate((50.0, 100.0, 200.0), start=1)
    ]
    undrained = []
    for n, start in enumerate((100.0, 200.0, 400.0), start=1):
        third = 0.45 * start
        undrained.append(
            [*UNDRAINED, str(n), start, start + 300.0, 300.0, start + 300.0 - third, 8.0, deviator(third), 1.0]
        )
    strength = {
        "TRET_TESN": ("", "X"),
        "TRET_CONP": ("kPa", "0DP"),
        "TRET_CELL": ("kPa", "0DP"),
        "TRET_PWPI": ("kPa", "0DP"),
        "TRET_PWPF": ("kPa", "0DP"),
        "TRET_STRN": ("%", "1DP"),
        "TRET_DEVF": ("kPa", "0DP"),
        "TRET_STRR": ("%/hr", "1DP"),
    }
    return {
        "PROJ": group("PROJ", {"PROJ_ID": ("", "ID"), "PROJ_NAME": ("", "X")}, [["1", "SYNTHETIC, not a real site"]]),
        "TRAN": group("TRAN", {"TRAN_AGS": ("", "X")}, [["4.1"]]),
        "CONG": group(
            "CONG",
            keyed(CONG_TYPE=("", "PA"), CONG_HIGT=("mm", "2DP"), CONG_IVR=("", "3DP")),
            [
                [*FIRST, "OEDOMETER", 19.25, E0],
                [*SECOND, "OEDOMETER", 20.0, 1.0],
                [*SWELLING, "SWELL", 20.0, 0.9],
            ],
        ),
        "CONS": group(
            "CONS",
            keyed(CONS_INCN=("", "X"), CONS_IVR=("", "3DP"), CONS_INCF=("kPa", "0DP"), CONS_INCE=("", "3DP")),
            [*compression(FIRST, PAST, E0), *compression(SECOND, 150.0, 1.0), [*SWELLING, "1", 0.9, 25.0, 0.95]],
        ),
        "TREG": group(
            "TREG",
            keyed(TREG_TYPE=("", "PA"), TREG_COH=("kPa", "0DP"), TREG_PHI=("deg", "1DP"), TREG_FCR=("", "X")),
            [[*DRAINED, "CD", 4.0, 28.5, "Maximum deviator stress"], [*UNDRAINED, "CU", "", "", ""]],
        ),
        "TRET": group("TRET", keyed(**strength), [*drained, *undrained]),
        "TRIG": group("TRIG", keyed(TRIG_TYPE=("", "PA")), [[*QUICK, "UU"]]),
        "TRIT": group(
            "TRIT",
            keyed(TRIT_TESN=("", "X"), TRIT_CELL=("kPa", "0DP"), TRIT_STRN=("%", "2SF"), TRIT_DEVF=("kPa", "0DP")),
            [[*QUICK, "1", 180.0, 9.5, 120.0]],
        ),
        "MONG": group(
            "MONG",
            {"LOCA_ID": ("", "ID"), "MONG_ID": ("", "X"), "MONG_DIS": ("m", "2DP"), "MONG_TYPE": ("", "PA")},
            [["BH3", "P1", "2.30", "VWP"]],
        ),
        "MOND": group(
            "MOND",
            {
                "LOCA_ID": ("", "ID"),
                "MONG_ID": ("", "X"),
                "MONG_DIS": ("m", "2DP"),
                "MOND_DTIM": ("yyyy-mm-ddThh:mm:ss", "DT"),
                "MOND_TYPE": ("", "PA"),
                "MOND_RDNG": ("", "XN"),
                "MOND_UNIT": ("", "PU"),
            },
            [
                ["BH3", "P1", "2.30", "2026-03-02T06:00:00", "PRES", "14.5", "kPa"],
                ["BH3", "P1", "2.30", "2026-03-01T12:00:00", "PRES", "12.0", "kPa"],
                ["BH3", "P1", "2.30", "2026-03-05T12:00:00", "PRES", "DRY", "kPa"],
                ["BH3", "P1", "2.30", "2026-03-11T12:00:00", "PRES", "20.25", "kPa"],
                ["BH3", "P1", "2.30", "2026-03-01T12:00:00", "LEV", "3.214", "m"],
            ],
        ),
    }


def content(**other: str) -> bytes:
    """The file; groups given here stand in for those of the same name, or are left out where they are empty."""
    return "".join({**groups(), **other}.values()).encode()
