"""BRO: the catalogue of cone tests (IMBRO and IMBRO/A), in XML."""

from pathlib import Path
from xml.etree import ElementTree as ET

from harness.interpret.reading.contents import (
    Heading,
    TestFile,
    check_marks,
    one_of,
    stated_values,
)
from harness.study.tables import StudyError

UNITS = {"depth": "m", "penetrationlength": "m"} | dict.fromkeys(
    ("inclinationresultant", "inclinationns", "inclinationew"), "deg"
)
"""Units, which the catalogue fixes; all other columns that are read are in MPa."""
MISSING = (-999999.0,)
STATED = {
    "area_ratio": ("coneSurfaceQuotient", "-"),
    "pre_drilled": ("predrilledDepth", "m"),
    "cone_area": ("coneSurfaceArea", "mm2"),
    "water_level": ("groundwaterLevel", "m"),
}
"""Elements, and their units by the catalogue."""


def read_bro(path: Path, text: str, sounding: str | None) -> TestFile:
    """An XML document; each test has the parameters that were measured, and rows of all of them."""
    if "<!DOCTYPE" in text:  # it can define entities, which may expand without end
        raise StudyError(f"{path}: has a document type, which no file of the BRO has")
    try:
        root = ET.fromstring(text)
    except (ET.ParseError, ValueError) as error:
        raise StudyError(f"{path}: is no whole XML: {error}") from None
    surveys = {
        element.findtext("{*}broId", f"test {number}"): (element, survey)
        for number, element in enumerate(root.iter(), start=1)
        if (survey := element.find("{*}conePenetrometerSurvey")) is not None
    }
    whole, survey = surveys[one_of(path, list(surveys), sounding)]
    parameters = survey.find("{*}parameters")
    result = survey.find("{*}conePenetrationTest/{*}cptResult")
    values = None if result is None else result.findtext("{*}values")
    encoding = None if result is None else result.find("{*}encoding/{*}TextEncoding")
    if parameters is None or values is None or encoding is None:
        raise StudyError(f"{path}: lacks parameters, TextEncoding or values of a cone test")
    titles = [(parameter.tag.partition("}")[2], parameter.text == "ja") for parameter in parameters]
    point, cell, block = (
        encoding.get(f"{name}Separator", usual)
        for name, usual in (("decimal", "."), ("token", ","), ("block", ";"))
    )
    check_marks(path, point, cell, block)
    to_points = str.maketrans(f"{point}.", f".{point}")
    found = {name: (whole.find(f".//{{*}}{tag}"), unit) for name, (tag, unit) in STATED.items()}
    return TestFile(
        headings=[
            Heading(
                title.lower() if is_there else "", title, UNITS.get(title.lower(), "MPa"), MISSING
            )
            for title, is_there in titles
        ],
        rows=[
            (number, [piece.strip().translate(to_points) for piece in row.split(cell)])
            for number, row in enumerate(values.split(block), start=1)
            if row.strip()
        ],
        row="row",
        stated=stated_values(
            **{
                name: (it.text, it.get("uom"), unit)
                for name, (it, unit) in found.items()
                if it is not None
            }
        ),
        in_order=False,
    )
