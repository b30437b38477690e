"""Silicones that soft fingers are commonly moulded of, by their names in a <finger>.

Where the maker states the stress at 100 % strain alone, Young's modulus is that of a neo-Hookean solid with that
stress: at stretch 2 the nominal stress is  E / 3 (2 - 1 / 2^2) . For Dragon Skin 10 (22 psi) that rule gives 260 kPa,
and bending of a cantilever 264 kPa. Batches differ by more than that: a finger of one's own is best identified.
"""

from typing import NamedTuple

_PSI = 6894.757  # Pa


class Silicone(NamedTuple):
    """What of it a cross-section needs, and where the values come from."""

    youngs_modulus: float  # Pa, of small strains
    density: float  # kg/m^3
    source: str


def _from_stress_at_twice_the_length(psi: float) -> float:
    """Young's modulus, Pa, of a neo-Hookean solid with that nominal stress at 100 % strain."""
    return 3 * psi * _PSI / (2 - 1 / 4)


_ECOFLEX = "Smooth-On, Ecoflex Series, technical bulletin: modulus at 100 % strain"
_CANTILEVER = "Sim-to-Real for Differentiable Projective Dynamics on Soft Robots, 2021"
_CONNOLLY = "F. Connolly et al., Mechanical Programming of Soft Actuators by Varying Fiber Angle, 2015"
_POLYGERINOS = "P. Polygerinos et al., Towards a Soft Pneumatic Glove for Hand Rehabilitation, 2013"
_DRAGON_SKIN = "Smooth-On, Dragon Skin Series, technical bulletin"
SILICONES = {
    "ecoflex_00_30": Silicone(_from_stress_at_twice_the_length(10), 1070.0, f"{_ECOFLEX} 10 psi"),
    "ecoflex_00_50": Silicone(_from_stress_at_twice_the_length(12), 1070.0, f"{_ECOFLEX} 12 psi"),
    "dragon_skin_10": Silicone(2.64e5, 1070.0, f"{_CANTILEVER}: bending of a cantilever; {_DRAGON_SKIN}"),
    "dragon_skin_30": Silicone(
        _from_stress_at_twice_the_length(86), 1080.0, f"{_DRAGON_SKIN}: modulus at 100 % strain 86 psi"
    ),
    "smooth_sil_950": Silicone(
        3 * 0.68e6, 1240.0, f"{_CONNOLLY}: neo-Hookean shear modulus 0.68 MPa; Smooth-On, Smooth-Sil Series"
    ),
    "elastosil_m4601": Silicone(
        6 * 0.11e6, 1130.0, f"{_POLYGERINOS}: Yeoh C1 = 0.11 MPa, E = 6 C1; Wacker, Elastosil M 4601, data sheet"
    ),
}
