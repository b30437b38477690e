"""Numbers in XML: the one place where their text is read."""

import re
import xml.etree.ElementTree as ET

from soft_gripper.errors import InputError

LEAST, MOST = 1e-30, 1e15  # of the size of a number that is not 0: all that models are made of, in SI units
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?|[-+]?inf(inity)?", re.ASCII | re.IGNORECASE)
_WORDS = {1: "a number", 2: "two numbers", 3: "three numbers", 4: "four numbers"}


def read_numbers(where: object, field: str, text: str, *counts: int) -> tuple[float, ...]:
    """The numbers of a text, which may be infinite.

    Args:
        where, field: for the message.
        text: numbers with white space between them.
        counts: how many there may be; none: any number of them.

    Raises:
        InputError: if it holds something else, or another number of them.
    """
    words = text.split()
    if any(_NUMBER.fullmatch(word) is None for word in words) or (counts and len(words) not in counts):
        expected = " or ".join(_WORDS.get(count, f"{count} numbers") for count in counts if count) or "numbers"
        raise InputError(where, field, text, f"give {expected}")
    return tuple(map(float, words))


def finite_numbers(where: object, field: str, text: str, *counts: int, least: float = LEAST) -> tuple[float, ...]:
    """The numbers of a text, as `read_numbers`, but finite and of a size that can be meant.

    `least` is 0 where rounding leaves numbers of any size that stand for 0, as in places, angles and products of
    inertia.

    Raises:
        InputError: if it holds anything else.
    """
    numbers = read_numbers(where, field, text, *counts)
    for number in numbers:
        if not (number == 0 or least <= abs(number) <= MOST):
            sizes = f"0, or {least:g} to {MOST:g}" if least else f"up to {MOST:g}"
            raise InputError(where, field, text, f"give finite numbers: {sizes} in size")
    return numbers


def number(where: object, element: ET.Element | None, attribute: str) -> float:
    """The value of an attribute; 0, as URDF has it, if the attribute or the element is missing.

    Raises:
        InputError: if it is no number.
    """
    text = "0" if element is None else element.get(attribute, "0")
    tag = "" if element is None else element.tag
    (value,) = read_numbers(where, f"{tag}.{attribute}", text, 1)
    return value
