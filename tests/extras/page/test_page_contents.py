import math

from pydrake.systems.primitives import PassThrough

from soft_gripper.extras.page.live_page import first_plots, list_plots
from soft_gripper.signals import describe


def port(size: int = 1, unit="m", **axes):
    return describe(PassThrough(size).get_output_port(), unit, **axes)


def test_fingers_share_a_plot_and_others_do_not() -> None:
    signals = {"left.pressure": port(unit="Pa"), "right.pressure": port(unit="Pa"), "grip.opening": port()}
    plots = list_plots(signals, ["left", "right"])
    assert list(plots) == ["pressure", "grip.opening"]
    assert list(plots["pressure"]["signals"]) == ["left.pressure", "right.pressure"]


def test_units_are_those_that_people_read() -> None:
    plots = list_plots({"a.b": port(unit="rad"), "a.c": port(unit="N")}, [])
    assert (plots["a.b"]["unit"], plots["a.c"]["unit"]) == ("deg", "N")
    assert math.isclose(math.pi * plots["a.b"]["scale"], 180)
    assert plots["a.c"]["scale"] == 1


def test_mixed_units_stay_as_they_are() -> None:
    plots = list_plots({"a.pose": port(3, ("m", "m", "rad"), pose=("x", "z", "heading"))}, [])
    entries = {"a.pose": ["x", "z", "heading"]}
    assert plots["a.pose"] == {"unit": "m, rad", "scale": 1.0, "axes": "pose", "signals": entries}


def test_entries_are_named_by_their_axes_and_a_scalar_is_one_line() -> None:
    plots = list_plots({"a.b": port(4, "m", path=("inner", "outer"), section=(0, 1)), "a.c": port()}, [])
    assert plots["a.b"]["signals"]["a.b"] == ["inner 0", "inner 1", "outer 0", "outer 1"]
    assert plots["a.c"]["signals"]["a.c"] == [""]


def test_the_first_plots_are_there() -> None:
    assert first_plots(["strain", "x", "pressure"]) == ["pressure", "strain"]
    assert first_plots(["pressure", "normal_force", "strain"]) == ["normal_force", "pressure", "strain"]
    assert first_plots(["pressure", "normal_force", "transverse_force"]) == ["transverse_force", "pressure"]
    assert first_plots(["external_torque", "strain", "tension", "theta"]) == ["tension", "external_torque", "theta"]
