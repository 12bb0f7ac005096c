"""Writers of one cone test as CSV, GEF, BRO, AGS 4 and SGF, and its site file."""

from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np

from harness.interpret.columns import Columns, read_columns
from harness.interpret.site import load_site
from tests.harness.interpret.conftest import LAYER, SITE, changed

Row = tuple[float, float, float, float]
"""Depth [m], qc [MPa], fs [MPa] and u2 [MPa]; not a number where one is missing."""


def cells(values: Iterable[float], missing: str) -> list[str]:
    return [missing if np.isnan(it) else repr(it) for it in values]


def as_csv(rows: list[Row]) -> str:
    lines = [",".join(cells(row, "")) for row in rows]
    return "\n".join(["depth [m],qc [MPa],fs [MPa],u2 [MPa]", *lines]) + "\n"


def as_gef(rows: list[Row]) -> str:
    """Of release 1.1; the columns in another order, with the length of the rods among them."""
    data = "\n".join(
        "; ".join(cells((z + 0.01, u2, z, fs, qc), "-999.0")) + ";!" for z, qc, fs, u2 in rows
    )
    voids = "\n".join(f"#COLUMNVOID= {number}, -999.0" for number in range(1, 6))
    return f"""#GEFID= 1, 1, 0
#REPORTCODE= GEF-CPT-Report, 1, 1, 2, -
#COMPANYID= Gr\u00fcndung BV, 1, 31
#COLUMN= 5
#COLUMNINFO= 1, m, Sondeerlengte, 1
#COLUMNINFO= 2, MPa, Waterspanning, 6
#COLUMNINFO= 3, m, Gecorrigeerde diepte, 11
#COLUMNINFO= 4, Mpa, Plaatselijke wrijving, 3
#COLUMNINFO= 5, MPa, Conusweerstand, 2
{voids}
#MEASUREMENTVAR= 1, 1500, mm2, oppervlakte conuspunt
#MEASUREMENTVAR= 3, 0.80, -, netto oppervlaktequotient
#MEASUREMENTVAR= 13, 1.55, m, voorgeboord
#COLUMNSEPARATOR= ;
#RECORDSEPARATOR= !
#LASTSCAN= {len(rows)}
#EOH=
{data}
"""


def as_bro(rows: list[Row], name: str = "CPT000000000001") -> str:
    """The columns in the order of the parameters, those that are not measured among them."""
    data = ";".join(
        ",".join(cells((z + 0.01, z, qc, np.nan, fs, u2), "-999999")) for z, qc, fs, u2 in rows
    )
    measured = (
        ("penetrationLength", "ja"),
        ("depth", "ja"),
        ("coneResistance", "ja"),
        ("netConeResistance", "nee"),
        ("localFriction", "ja"),
        ("porePressureU2", "ja"),
    )
    parameters = "".join(f"<c:{it}>{answer}</c:{it}>" for it, answer in measured)
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<dispatchDataResponse xmlns="http://www.broservices.nl/xsd/dscpt/1.1"
 xmlns:b="http://www.broservices.nl/xsd/brocommon/3.0" xmlns:swe="http://www.opengis.net/swe/2.0"
 xmlns:c="http://www.broservices.nl/xsd/cptcommon/1.1"><dispatchDocument><CPT_O>
<b:broId>{name}</b:broId><conePenetrometerSurvey>
<c:trajectory><c:predrilledDepth uom="m">1.55</c:predrilledDepth></c:trajectory>
<c:conePenetrometer><c:coneSurfaceArea uom="mm2">1500</c:coneSurfaceArea>
<c:coneSurfaceQuotient>0.80</c:coneSurfaceQuotient></c:conePenetrometer>
<c:conePenetrationTest><c:cptResult><swe:encoding>
<swe:TextEncoding decimalSeparator="." tokenSeparator="," blockSeparator=";"/></swe:encoding>
<c:values>{data}</c:values></c:cptResult></c:conePenetrationTest>
<c:parameters>{parameters}</c:parameters>
</conePenetrometerSurvey></CPT_O></dispatchDocument></dispatchDataResponse>
"""


def as_ags(rows: list[Row], *names: str) -> str:
    """Groups PROJ, SCPG and SCPT of AGS 4.1; the same test at each name."""
    names = names or ("CPT1",)
    general = "\n".join(f'"DATA","{it}","1","0.80","15"' for it in names)
    data = "\n".join(
        f'"DATA","{it}","1","{z!r}","' + '","'.join(cells((qc, 1e3 * fs, 1e3 * u2), "")) + '"'
        for it in names
        for z, qc, fs, u2 in rows
    )
    return f""""GROUP","PROJ"
"HEADING","PROJ_ID","PROJ_NAME"
"UNIT","",""
"TYPE","ID","X"
"DATA","1","A site, a ""quoted"" one"

"GROUP","SCPG"
"HEADING","LOCA_ID","SCPG_TESN","SCPG_CAR","SCPG_CSA"
"UNIT","","","","cm2"
"TYPE","ID","X","2DP","0DP"
{general}

"GROUP","SCPT"
"HEADING","LOCA_ID","SCPG_TESN","SCPT_DPTH","SCPT_RES","SCPT_FRES","SCPT_PWP2"
"UNIT","","","m","MN/m2","kN/m2","kN/m2"
"TYPE","ID","X","2DP","2DP","2DP","2DP"
{data}
"""


def as_sgf(rows: list[Row], *names: str) -> str:
    """After a rotary sounding the same cone test at each name; rows have a time, some a remark."""
    data = "\n".join(
        f"D={z!r},"
        + ",".join(
            f"{code}={cell}"
            for code, cell in zip(
                ("QC", "FS", "U"), cells((qc, 1e3 * fs, 1e3 * u2), ""), strict=True
            )
            if cell
        )
        + f",TA=0.0,%{1270 + place}\nK=0"
        for place, (z, qc, fs, u2) in enumerate(rows)
    )
    tests = "".join(
        f"$\nHA=1,HK={name},HM=07,HO=1.55,MA=0.80,\n,MB=0.005,MC=15.0\n#\n{data}\n#$\n"
        for name in names or ("CPT1",)
    )
    return f"\n$ \nHK=R1,HM=23\n#\nD=0.025,A=0.892,B=11.1,R=0\n#$\n{tests}"


WRITERS: dict[str, Callable[[list[Row]], str]] = {
    "csv": as_csv,
    "gef": as_gef,
    "xml": as_bro,
    "ags": as_ags,
    "cpt": as_sgf,
}


def rows_of(folder: Path) -> list[Row]:
    """The test of the folder, in which three values are missing."""
    text = (folder / "test.csv").read_text().splitlines()[1:]
    found = np.array([[float(it) for it in line.split(",")] for line in text])
    found[:, 2:] /= 1e3
    found[[10, 20, 30], [1, 2, 3]] = np.nan
    return [(z, qc, fs, u2) for z, qc, fs, u2 in found.tolist()]


def site_of(folder: Path, kind: str, text: str, *changes: tuple[str, str]) -> Path:
    """A site file for a test of a kind."""
    (folder / f"test.{kind}").write_text(text, encoding="latin-1" if kind == "gef" else "utf-8")
    (folder / "site.toml").write_text(SITE + LAYER)
    return changed(folder, ('"test.csv"', f'"test.{kind}"'), *changes)


def columns_of(path: Path) -> Columns:
    return read_columns(load_site(path).test)
