"""All keys of a site file: meaning, unit, allowed values and default of each.

`SITE_KEYS` are at the top of the file, `TEST_KEYS` under [test], `LAYER_KEYS` under [[layer]].
Site files are read, written, described and checked by these keys.
"""

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from harness.interpret.factors import TABLE_RATE
from harness.study.distributions import HOW
from mpm_warp.checks import FINITE, NOT_NEGATIVE, Range

MEASURES = ("tip", "sleeve", "pore_pressure")
"""Measurements by which strength may be found."""
COLUMNS = ("depth", "qc", "fs", "u2")
"""Quantities that are read from a test file."""
AXES = ("inclination", "inclination_across")
"""Optional quantities: the inclination of the cone, or those in two planes at right angles."""
BY_SLEEVE = "sleeve"
"""Value of the adhesion factor by which it follows from the sleeve friction at each depth."""
MODES = ("isotropic", "simple_shear", "triaxial_compression", "triaxial_extension", "average")
"""Modes of the strength to be found; isotropic is the strength of the simulation."""
ACCURACY: Mapping[str, Mapping[str, tuple[float, float]]] = {
    "class 1": {"qc": (35e3, 0.05), "fs": (5e3, 0.10), "u2": (10e3, 0.02)},
    "class 2": {"qc": (100e3, 0.05), "fs": (15e3, 0.15), "u2": (25e3, 0.03)},
    "class 3": {"qc": (200e3, 0.05), "fs": (25e3, 0.15), "u2": (50e3, 0.05)},
}
"""Allowed errors by class of EN ISO 22476-1:2012 as commonly quoted: the larger of a value in Pa
and a share of the reading. They are taken as half widths of 95 %, constant along the test."""
LARGEST_DEPTH = 1000.0
MODE_RATIO = Range(above=0, maximum=1.2)
"""Allowed ratio of su in another mode to su in compression."""
RATE = r"(\d+\.?\d*) ?%/(s|min|h)"
"""Pattern of a strain rate that is written as text."""


class Form(Enum):
    """Ways to write the value of a key, each with its text for the user."""

    TEXT = "a text"
    NUMBER = "a number"
    INTEGER = "an integer"
    INPUT = HOW
    BY_DEPTH = "{ depth = [..], value = [..] }"
    NUMBERS = "a list of numbers"
    WORDS = "a list of"
    TEXTS = "{ depth, qc, fs, u2, inclination, inclination_across }, each a text"
    ERRORS = "{ qc, fs, u2 } [kPa], half widths of 95 %"
    RATE = 'a text as "5 %/h"'


@dataclass(frozen=True)
class Key:
    """A key of a site file."""

    meaning: str
    allowed: Range = FINITE  # range of its numbers
    forms: tuple[Form, ...] = ()  # allowed forms, besides `choices`
    unit: str = ""  # of its numbers, "" if it has none
    choices: tuple[str, ...] = ()  # allowed texts
    default: object = None  # None: no default
    required: bool = False

    @property
    def in_unit(self) -> str:
        """The unit in brackets after a blank, or ""."""
        return f" [{self.unit}]" if self.unit else ""

    @property
    def description(self) -> str:
        """Meaning, unit and allowed values, in one line."""
        bounds = f" {self.allowed.allowed}" if self.allowed.allowed else ""
        forms = [form.value for form in self.forms if form is not Form.WORDS]
        if any(form in self.forms for form in (Form.NUMBER, Form.INTEGER, Form.INPUT)):
            forms[0] = ("an input" if self.forms[0] is Form.INPUT else forms[0]) + bounds
        words = ", ".join(self.choices)
        if self.choices:
            forms.append(f"a list of {words}" if Form.WORDS in self.forms else words)
        return f"{self.meaning}{self.in_unit}; {', or '.join(forms)}"


_text = functools.partial(Key, forms=(Form.TEXT,))
_texts = functools.partial(Key, forms=(Form.TEXTS,))
_integer = functools.partial(Key, forms=(Form.INTEGER,))
_number = functools.partial(Key, forms=(Form.NUMBER,))
_input = functools.partial(Key, forms=(Form.INPUT,), unit="1")

SITE_KEYS: Mapping[str, Key] = {
    "title": _text("title of the test", required=True),
    "use": Key(
        "measurements by which strength is found, the tip first",
        forms=(Form.WORDS,),
        choices=MEASURES,
        default=[MEASURES[0]],
    ),
    "samples": _integer(
        "number of random combinations of the inputs",
        Range(minimum=512, maximum=65536),
        default=2048,
    ),
    "seed": _integer("seed of the random numbers", Range(minimum=0, maximum=1e9), default=1),
}
TEST_KEYS: Mapping[str, Key] = {
    "file": _text(
        "the measured test, CSV, GEF (.gef), BRO (.xml), AGS 4 (.ags) or SGF", required=True
    ),
    "sounding": _text("name of the test, in a file of several"),
    "columns": _texts("names of the columns in the file, if they are not the usual ones"),
    "units": _texts("units of the columns, in place of those in the file"),
    "missing": Key(
        "codes for a missing value, besides those in the file; [] if values like -999 are measured",
        forms=(Form.NUMBERS,),
    ),
    "ground_level": _number(
        "level of the ground, if the file has levels, positive upward, not depths", unit="m"
    ),
    "pre_drilled": _number(
        "pre-drilled depth, by default that in the test file, or 0", NOT_NEGATIVE, unit="m"
    ),
    "area_ratio": _number(
        "net area ratio of the cone on its calibration sheet, 1 if qc is corrected; a CSV does not "
        "have it, other files may",
        Range(above=0, maximum=1),
        unit="1",
    ),
    "cone_area": _number(
        "cross-section of the cone, by default that in the test file, or 10",
        Range(minimum=1, maximum=100),
        unit="cm2",
    ),
    "water_level": _number(
        "depth of the ground water, with hydrostatic pressure below; negative if water stands on "
        "the ground, with its pressure in qc and u2",
        unit="m",
        required=True,
    ),
    "u0": Key(
        "water pressure by depth [m], in place of water_level", forms=(Form.BY_DEPTH,), unit="kPa"
    ),
    "unit_weight": Key(
        "total unit weight of the ground, not the buoyant one",
        Range(minimum=10, maximum=30),
        forms=(Form.INPUT, Form.BY_DEPTH),
        unit="kN/m3",
        required=True,
    ),
    "accuracy": Key(
        "class of EN ISO 22476-1, or the errors of the test",
        forms=(Form.ERRORS,),
        choices=tuple(ACCURACY),
        default="class 2",
    ),
}
LAYER_KEYS: Mapping[str, Key] = {
    "title": _text("title of the layer, by default its depths"),
    "from": _number("depth of its top", NOT_NEGATIVE, unit="m", required=True),
    "to": _number(
        "depth of its bottom", Range(above=0, maximum=LARGEST_DEPTH), unit="m", required=True
    ),
    "rigidity_index": _input("Ir = G / su", Range(minimum=15, maximum=1000), required=True),
    "adhesion_factor": _input(
        "adhesion factor alpha; sleeve: by fs at each depth",
        Range(minimum=0, maximum=1),
        choices=(BY_SLEEVE,),
        default={"low": 0.2, "high": 0.8},
    ),
    "K0": _input(
        "effective horizontal over vertical stress",
        Range(above=0, maximum=5),
        default={"low": 0.5, "high": 0.8},
    ),
    "stress_anisotropy": _input(
        "Delta = (sigma_v0 - sigma_h0) / (2 su), in place of K0", Range(minimum=-0.6, maximum=0.9)
    ),
    "rate_factor": _input(
        "increase of su per log cycle of strain rate, over su",
        Range(minimum=0, maximum=0.25),
        default={"mean": 0.1, "deviation": 0.03},
    ),
    "laboratory_rate": Key(
        "shear strain rate of the su to be found",
        Range(minimum=TABLE_RATE, maximum=1e-2),
        forms=(Form.NUMBER, Form.RATE),
        unit="1/s",
        default="1 %/h",
    ),
    "sensitivity": _input(
        "intact over remoulded strength",
        Range(minimum=1, maximum=25),
        default={"low": 1.5, "high": 6.0},
    ),
    "ductility": _input(
        "plastic shear strain at which 95 % of the loss of strength is reached",
        Range(minimum=5, maximum=60),
        default={"low": 10, "high": 50},
    ),
    "strength": Key(
        "mode of the su to be found; isotropic: as in the simulation",
        choices=MODES,
        default=MODES[0],
    ),
    "simple_shear_ratio": _input(
        "su in simple shear over compression", MODE_RATIO, default={"low": 0.6, "high": 0.9}
    ),
    "extension_ratio": _input(
        "su in extension over compression", MODE_RATIO, default={"low": 0.35, "high": 0.7}
    ),
    "model_error": _number(
        "standard deviation of the error by what the simulation leaves out, over Nkt",
        Range(minimum=0, maximum=1),
        unit="1",
        default=0.1,
    ),
}
INPUTS = ("rigidity_index", "rate_factor", "sensitivity", "ductility")
"""Inputs that are constant in a layer."""
