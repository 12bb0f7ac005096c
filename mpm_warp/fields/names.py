"""The name that is meant by a wrong one: the nearest, or that of a symbol or word of the field."""

import difflib
from collections.abc import Collection, Container, Iterable

ALIASES: dict[str, dict[str, str]] = {
    "ir rigidity rigidity_index": {"rigidity_index": "G / su", "shear_modulus": "Ir su, in Pa"},
    "g gmod shear_modulus stiffness": {"shear_modulus": "in Pa", "rigidity_index": "G / su"},
    "e eu youngs_modulus": {
        "shear_modulus": "E / (2 (1 + nu)), in Pa",
        "rigidity_index": "G / su with G = E / (2 (1 + nu))",
    },
    "su cu c strength undrained_strength shear_strength cohesion": {
        "undrained_shear_strength": "in Pa",
        "strength": "",
    },
    "alpha a roughness adhesion": {
        "adhesion_factor": "adhesion over su, 0 smooth to 1 rough",
        "adhesion": "in Pa",
    },
    "k0": {
        "K0": "",
        "stress_anisotropy": "(1 - K0) sigma_v0' / (2 su)",
        "material.earth_pressure_at_rest": "of modified_cam_clay",
    },
    "ocr overconsolidation_ratio": {
        "material.vertical_overconsolidation_ratio": "by effective vertical stress",
        "material.isotropic_overconsolidation_ratio": "p_c over p'",
    },
    "m phi friction_angle": {"material.critical_state_ratio": "6 sin(phi) / (3 - sin(phi))"},
    "anisotropy delta": {"stress_anisotropy": "(sigma_v0 - sigma_h0) / (2 su)"},
    "sensitivity st delta delta_rem remoulded_strength": {
        "remoulded_strength_ratio": "1 / sensitivity"
    },
    "friction mu": {
        "friction_coefficient": "tan of the angle of friction",
        "friction": "tan of the angle of friction",
    },
    "mu": {"rate_factor": "what a log cycle of strain rate adds to su, over su"},
    "xi_95 xi95 softening": {
        "ductility": "plastic shear strain at which 95 % of the loss of strength is done"
    },
    "nu poisson poisson_ratio": {"poissons_ratio": ""},
    "rho mass_density": {"density": "in kg/m3"},
    "gamma unit_weight": {"unit_weight": "", "density": "unit weight over 9.81 m/s2, in kg/m3"},
    "sigma_v0 sigma_v sigma_0 sigma0 p0 total_stress overburden": {"in_situ_stress": "in Pa"},
    "r radius": {"cone_radius": "in m", "interface_radius": "in m"},
    "d diameter cone_diameter": {"cone_radius": "half the diameter, in m"},
    "area cone_area": {"cone_radius": "sqrt(area / pi), in m"},
    "angle cone_angle apex beta": {"apex_angle": "in degrees", "slope": "in degrees"},
    "z depth travel distance": {
        "depth": "",
        "penetration": "over the cone radius",
        "displacement": "over the radius, times G / su",
        "travel": "over the length",
    },
    "v speed velocity rate penetration_rate": {
        "speed_ratio": "speed over that of shear waves, sqrt(G / density)"
    },
    "h dx mesh mesh_size cell_size resolution cells": {
        "cells_per_radius": "radius over cell size",
        "cells_per_length": "length over cell size",
        "cells_per_side": "side over cell size",
        "cell_count": "length over cell size",
    },
    "ppc particles points_per_cell": {"particles_per_cell": ""},
    "dt time_step": {"time_step_fraction": "time step over the critical one"},
    "model criterion yield_criterion constitutive_model": {"material": ""},
}
"""Words in lower case, the parameters that they may mean, and the value of each parameter."""
SCENES = {
    "cone": "cone_penetration",
    "cpt": "cone_penetration",
    "cptu": "cone_penetration",
    "tbar": "t_bar_penetration",
    "footing": "circular_footing",
}
"""Words in lower case, and the scene that is most likely meant."""
RESULTS = ("nc", "nkt", "qc", "qt", "qnet", "fs", "cone_factor", "bearing_capacity")
"""Words for results, which are not parameters."""


def what_to_give(word: str, known: Container[str]) -> str:
    """A phrase that names the `known` parameters that a word may mean; "" for none."""
    small = word.lower()
    if small in RESULTS:
        return "; it is a result, not a parameter"
    offers = [
        f"{name!r}" + (f", {value}" if value else "")
        for words, meanings in ALIASES.items()
        for name, value in meanings.items()
        if small in words.split() and name in known
    ]
    return f"; give {', or '.join(offers)}" if offers else ""


def did_you_mean(name: str, known: Iterable[str], likeness: float = 0.6) -> str:
    """A phrase with the nearest valid name; "" if none has this likeness, 0 to 1 for the same."""
    close = difflib.get_close_matches(name, list(known), n=1, cutoff=likeness)
    return f"; did you mean {close[0]!r}?" if close else ""


def known_names(known: Iterable[str]) -> str:
    """A phrase with all valid names; "" for none."""
    names = ", ".join(known)
    return f"; known: {names}" if names else ""


def nearest_name(name: str, known: Iterable[str]) -> str:
    """A phrase with the nearest valid name, or with all if none is near.

    An alias of a scene comes first. A name that begins with the words given is near at any length.
    """
    names = list(known)
    meant = SCENES.get(name.lower(), "")
    own = [longer for longer in names if longer.endswith(f".{name}")]  # of a law
    if likely := next((it for it in (meant, *own) if it in names), None):
        return f"; did you mean {likely!r}?"
    begun = [longer for longer in names if longer.startswith(f"{name}_")]
    return did_you_mean(name, names) or did_you_mean(name, begun, 0.0) or known_names(names)


def nearest_parameter(name: str, known: Collection[str]) -> str:
    """A phrase with what to give instead: the meaning of an alias, or the nearest name.

    That of a parameter of a law, "material.m", is one of a law too.
    """
    of_all, dot, word = name.rpartition(".")
    alike = [it for it in known if it.startswith(of_all + dot)]
    return what_to_give(word, alike) or nearest_name(name, alike or known)
