"""Models that are simulated: grippers, arms and objects, reached as package://soft_gripper/..."""

from functools import cache
from pathlib import Path

from pydrake.multibody.parsing import PackageMap

from soft_gripper import extras

PACKAGE = "soft_gripper"
DIRECTORY = Path(__file__).parent


def package_map() -> PackageMap:
    """Where package:// URIs lead: the shipped models, those of extras, and the packages that Drake knows."""
    return PackageMap(_packages())


@cache  # reading the files takes 0.5 ms, and a station asks for each of its models
def _packages() -> PackageMap:
    packages = PackageMap()
    for file in (DIRECTORY / "package.xml", *Path(extras.__path__[0]).glob("*/package.xml")):
        packages.AddPackageXml(str(file))
    return packages
