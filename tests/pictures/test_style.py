"""Styles of figures: any number of estimators can be told apart."""

from soft_gripper.pictures.style import estimator_style


def test_estimators_beyond_the_colours_look_different():
    looks = [estimator_style(place, str(place)) for place in range(20)]
    assert len({(look["color"], look["marker"], look["ls"]) for look in looks}) == 20
