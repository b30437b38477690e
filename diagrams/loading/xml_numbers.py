"""Numbers in XML attributes."""

import math
import xml.etree.ElementTree as ET

from soft_gripper.errors import InputError


def number(where: str, element: ET.Element | None, attribute: str) -> float:
    """The value of an attribute; 0, as URDF has it, if the attribute or the element is missing.

    Raises:
        InputError: if it is no number.
    """
    text = "0" if element is None else element.get(attribute, "0")
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if math.isnan(value):
        tag = "" if element is None else element.tag
        raise InputError(where, f"{tag}.{attribute}", text, "give a number")
    return value
