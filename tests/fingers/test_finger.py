"""Finger: parameters -> the chain's stiffness, masses, limits; compared with the beam and with Drake."""

from dataclasses import replace

import numpy as np
import pytest
from finger_plants import built_at
from refusals import refused
from scipy.integrate import quad

from soft_gripper.errors import InputError
from soft_gripper.fingers.finger_parts import YIELDS, CreepBranch, ElasticLaw, TipLoad

# Softer in the middle than at the ends of the curve, and softer at the tip of the finger than at its base.
LAW = ElasticLaw((-30.0, -10.0, 5.0, 40.0), (-0.5, -0.1, 0.05, 0.8), (-0.3, -0.06, 0.02, 0.4))

MAY_BE_ZERO = ("relaxation_time", "friction", "dissipation", "chamber_width", "chamber_thickness")
MAY_BE_ZERO += ("layer_thickness", "layer_modulus", "layer_shear_modulus", "shear_factor")


@pytest.mark.parametrize(
    ("yields", "named"),
    [
        (("sideways", "twist"), ("yields", "sideways twist")),
        ((), ("yields", "")),
        (("bending", "twist", "twist"), ("yields", "bending twist twist")),
        (("bending", "sideways"), ("yields", "bending sideways")),
        (("bending", "shear"), ("yields[1]", "shear")),
        ("bending", ("yields", "bending")),
    ],
)
def test_ways_to_yield_that_are_wrong(shipped_finger, yields, named):
    with refused(*named):
        replace(shipped_finger, yields=yields)


def test_only_a_finger_in_its_plane_shears(shipped_finger):
    with refused("shear_factor", 0.8):
        replace(shipped_finger, yields=("bending", "twist"), shear_factor=0.8)


def test_the_shear_modulus_of_a_layer_is_given_at_both_ends_or_at_neither(shipped_finger):
    base, tip = (replace(end, layer_shear_modulus=1e7) for end in (shipped_finger.base, shipped_finger.tip))
    assert replace(shipped_finger, base=base, tip=tip).section(0.06).layer_shear_modulus == 1e7
    for one in ({"base": base}, {"tip": tip}):
        with refused("layer_shear_modulus", 1e7):
            replace(shipped_finger, **one)


def test_every_other_segment_has_its_joints_in_reverse(shipped_finger):
    assert shipped_finger.deformations(1) == ("bending",)
    finger = replace(shipped_finger, yields=("twist", "bending", "sideways"))
    assert [finger.deformations(i) for i in (0, 1, 2)] == [
        ("bending", "sideways", "twist"),
        ("twist", "sideways", "bending"),
        ("bending", "sideways", "twist"),
    ]


def test_segments_far_shorter_than_thick(shipped_finger):
    with refused("segments", 12):
        replace(shipped_finger, base=replace(shipped_finger.base, thickness=1e9))


def test_an_elastic_law_keeps_more_than_creeps_away(shipped_finger):
    flat, creep = linear_law(shipped_finger, 0.3), (CreepBranch(0.2, 0.3), CreepBranch(0.1, 4.0))
    with refused("creep.share", [0.2, 0.1]):
        replace(shipped_finger, elastic_law=flat, creep=creep)
    replace(shipped_finger, elastic_law=linear_law(shipped_finger, 0.35), creep=creep)


def at_joints(finger, quantity):
    """Of the cross-sections at the middles of the segments."""
    places = (np.arange(finger.segments) + 0.5) * finger.length / finger.segments
    return np.array([getattr(built_at(finger, s), quantity) for s in places])


def test_stiffness_is_that_of_the_cross_section(tapered_finger):
    expected = at_joints(tapered_finger, "bending_stiffness") / (tapered_finger.length / tapered_finger.segments)
    np.testing.assert_allclose(tapered_finger.stiffness, expected, rtol=1e-12)
    np.testing.assert_allclose(tapered_finger.damping, tapered_finger.relaxation_time * expected, rtol=1e-12)


def test_elastic_law_runs_through_its_points_and_straight_on(tapered_finger):
    finger = replace(tapered_finger, elastic_law=LAW)
    along = (np.arange(5) + 0.5) / 5
    points = [(1 - along) * base + along * tip for base, tip in zip(LAW.base_moment, LAW.tip_moment, strict=True)]

    def torque(curvature):
        return finger.elastic_torque(np.full(5, curvature * 0.12 / 5))

    for curvature, point in zip(LAW.curvature, points, strict=True):
        np.testing.assert_allclose(torque(curvature), point, rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(torque(22.5), (points[2] + points[3]) / 2, rtol=1e-12)
    np.testing.assert_allclose(torque(75.0), 2 * points[3] - points[2], rtol=1e-12)


def test_elastic_law_is_invertible(tapered_finger, bent):
    finger, q = replace(tapered_finger, elastic_law=LAW), 4 * bent(3, 5)
    np.testing.assert_allclose(finger.angle(finger.elastic_torque(q)), q, rtol=1e-12)


def linear_law(finger, factor):
    """The bending stiffness of a uniform finger, times `factor`, as an elastic law."""
    moment = factor * finger.stiffness[0] * finger.segment_length
    return ElasticLaw((-1.0, 1.0), (-moment, moment), (-moment, moment))


@pytest.mark.parametrize(
    ("field", "values"),
    [
        ("curvature", (0.0,)),
        ("curvature", (-1.0, 0.0, 0.0, 1.0)),
        ("curvature", (-1.0, 0.0, 1.0, float("nan"))),
        ("base_moment", (-1.0, 0.0, 1.0)),
        ("base_moment", (-1.0, 0.5, 0.2, 1.0)),
        ("tip_moment", (-1.0, 0.0, 1.0, float("inf"))),
    ],
)
def test_impossible_elastic_laws(shipped_finger, field, values):
    with pytest.raises(InputError) as caught:
        replace(shipped_finger, elastic_law=replace(LAW, **{field: values}))
    assert caught.value.field.partition("[")[0] == f"elastic_law.{field}"


def beam_value(finger, density):
    """Integral of `density(s)` over the length of the continuous beam."""
    return quad(density, 0, finger.length, epsabs=0, epsrel=1e-12)[0]


def test_chain_converges_to_the_beam_with_the_square_of_the_segment(tapered_finger):
    def free_bend(s):
        """Curvature of the beam per pascal."""
        section = built_at(tapered_finger, s)
        return section.chamber_area * section.chamber_eccentricity / section.bending_stiffness

    exact = beam_value(tapered_finger, free_bend)
    chains = [replace(tapered_finger, segments=n) for n in (20, 40, 80)]
    errors = [abs((chain.pressure_gain / chain.stiffness).sum() - exact) for chain in chains]
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 2, atol=0.1)


@pytest.mark.parametrize("load", [None, TipLoad(0.05, 0.015, -0.004)])
@pytest.mark.parametrize("segments", [1, 2, 5, 12])
def test_mass_matrix_is_drakes(tapered_finger, finger_plant, segments, load):
    finger = replace(tapered_finger, segments=segments, tip_load=load)
    plant = finger_plant(finger)
    mass_matrix = plant.CalcMassMatrix(plant.CreateDefaultContext())
    np.testing.assert_allclose(finger.mass_matrix(), mass_matrix, rtol=1e-12)


@pytest.mark.parametrize("segments", range(1, 16))
def test_sections_hold_whole_segments_as_equal_as_can_be(shipped_finger, segments):
    finger = replace(shipped_finger, segments=segments)
    for sections in range(1, segments + 1):
        ends = finger.section_ends(sections)
        sizes = np.diff(ends)
        assert (ends[0], ends[-1], len(sizes)) == (0, segments, sections)
        assert sizes.min() >= 1
        assert np.ptp(sizes) <= 1


@pytest.mark.parametrize("sections", [-1, 0, 13])
def test_impossible_sections(shipped_finger, sections):
    with refused("sections", sections):
        shipped_finger.section_ends(sections)


def spectral_radius(plant):
    """Growth, per step, of the fastest growing small motion of a discrete plant about its straight pose."""
    context = plant.CreateDefaultContext()
    columns, small = [], 1e-6
    for direction in np.eye(plant.num_multibody_states()):
        context.SetDiscreteState(small * direction)
        columns.append(plant.EvalUniquePeriodicDiscreteUpdate(context).value() / small)
    return np.abs(np.linalg.eigvals(np.column_stack(columns))).max()


REAL = {"shear_factor": 0.857, "tip_load": TipLoad(0.02, 0.005, -0.004)}
SPATIAL = REAL | {"shear_factor": 0.0, "yields": YIELDS}


@pytest.mark.parametrize("parts", [{}, REAL, SPATIAL], ids=["plain", "real", "spatial"])
@pytest.mark.parametrize("relaxation_time", [0.0, 1e-4, 0.015])
@pytest.mark.parametrize("segments", [1, 3, 12])
def test_stable_time_step_is_where_drakes_own_step_begins_to_grow(
    shipped_finger, finger_plant, segments, relaxation_time, parts
):
    finger = replace(shipped_finger, segments=segments, relaxation_time=relaxation_time, **parts)
    limit = finger.stable_time_step()
    assert spectral_radius(finger_plant(finger, 0.999 * limit)) < 1 + 1e-6
    assert spectral_radius(finger_plant(finger, 1.001 * limit)) > 1 + 1e-4


@pytest.mark.parametrize("factor", [0.3, 4.0])
def test_stable_time_step_with_another_elastic_law(shipped_finger, finger_plant, factor):
    """The damping stays that of Young's modulus: a stiffer law has a shorter relaxation time."""
    finger = replace(shipped_finger, tip=shipped_finger.base, segments=3)
    limit = replace(finger, elastic_law=linear_law(finger, factor)).stable_time_step()
    moduli = {name: factor * getattr(finger.base, name) for name in ("youngs_modulus", "layer_modulus")}
    section = replace(finger.base, **moduli)
    alike = replace(finger, base=section, tip=section, relaxation_time=finger.relaxation_time / factor)
    assert spectral_radius(finger_plant(alike, 0.999 * limit)) < 1 + 1e-6
    assert spectral_radius(finger_plant(alike, 1.001 * limit)) > 1 + 1e-4


def test_sensor_paths_lie_in_the_finger_at_both_ends(shipped_finger):
    room = shipped_finger.tip.thickness
    assert replace(shipped_finger, sensor_spacing=room).sensor_spacing == room
    deeper = float(shipped_finger.base.inner_face - shipped_finger.tip.inner_face)
    beyond = f"{0.5 - 1e3 * deeper:.2g} mm outside the finger at its base"
    with pytest.raises(InputError, match=f"sensor_spacing = .*: a sensor path would lie {beyond}"):
        replace(shipped_finger, sensor_spacing=room + 1e-3)
    bare = replace(shipped_finger.tip, layer_thickness=0.0, layer_modulus=0.0)
    with refused("sensor_spacing", 0.017):
        replace(shipped_finger, tip=bare)
