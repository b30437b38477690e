"""Models that are simulated: grippers, arms and objects, reached as package://soft_gripper/..."""

from pathlib import Path

from pydrake.multibody.parsing import PackageMap

PACKAGE = "soft_gripper"
DIRECTORY = Path(__file__).parent


def package_map() -> PackageMap:
    """Where package:// URIs lead: the shipped models, and the packages that Drake knows."""
    packages = PackageMap()
    packages.AddPackageXml(str(DIRECTORY / "package.xml"))
    return packages
