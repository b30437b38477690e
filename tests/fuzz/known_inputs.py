"""Hostile and mistaken input that is known: files, and commands with what they must say of it."""

from pathlib import Path

from command_line import short

from soft_gripper.models import DIRECTORY

Said = str | tuple[str, ...]

FINGER = (DIRECTORY / "grippers/finger.urdf").read_text()
_LINK = '<robot name="r"><link name="l"><visual>{}</visual></link></robot>'
_SDF = '<sdf version="1.7"><model name="m"><link name="l">{}</link></model></sdf>'
_RING = "".join(
    f'<joint name="{parent}{child}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
    '<limit lower="-1" upper="1" velocity="1" effort="1"/></joint>'
    for parent, child in ("ab", "ba")
)
_LIMP = """<robot name="limp"><link name="base_link"/><link name="tool0"/><joint name="shoulder" type="revolute">
<parent link="base_link"/><child link="tool0"/><limit velocity="0" effort="0"/></joint></robot>"""
_LONG = "n" * 300

FILES: dict[str, str | bytes] = {  # beside them: loop.urdf, a link to itself, pipe.urdf, which is one, and a folder
    "file": "a file, below which nothing can be written, not even by root",
    "finger.urdf": FINGER,
    "one_finger.yaml": (Path(__file__).parents[1] / "scenarios/defaults.yaml").read_text(),
    "limp.urdf": _LIMP,
    "no_finger.urdf": "<robot name='plain'><link name='base'/></robot>",
    **{f"binary.{ending}": b"\xff\xfe\x00" for ending in ("yaml", "urdf")},
    **{f"broken.{ending}": "a: [1" for ending in ("yaml", "urdf")},
    **{f"list.{ending}": "- 1" for ending in ("yaml", "urdf")},
    **{f"empty.{ending}": "" for ending in ("yaml", "urdf")},
}
CASES: dict[tuple[str, ...], Said] = {
    ("run", "free_bendig"): ("name = 'free_bendig'", "free_bending"),
    ("run", "free_bending", "--sections", "0"): "--sections = '0'",
    ("run", "free_bending", "--sections", "99"): "sections = 99",
    ("run", "free_bending", "--sections", "four"): "--sections = 'four'",
    ("expand", "no_finger.urdf"): ("no_finger.urdf", "finger"),
    ("show", f"{_LONG}.yaml"): "scenario = ",
    ("place-sensors", "--scenarios", "free_bending", "--count", "13"): "count = 13: give 1 to 12",
    (
        "place-sensors",
        "--count",
        "2",
        "--scenarios",
        "free_bending,nowhere",
    ): "name = 'nowhere': not shipped",
    (
        "place-sensors",
        "--count",
        "2",
        "--scenarios",
        "pick_and_place_box",
    ): "pick_and_place_box: task",
    (
        "place-sensors",
        "--count",
        "2",
        "--recordings",
        "none.nc",
    ): "none.nc: file = 'none.nc': cannot be read",
    (
        "place-sensors",
        "--count",
        "2",
        "--contacts",
        "none.nc",
    ): "none.nc: file = 'none.nc': cannot be read",
    ("grasp-trials", "--scenario", "nowhere"): "name = 'nowhere': not shipped",
    ("grasp-trials", "--scenario", "box_grasp"): "task = None: give a task for the trials",
    ("grasp-trials", "--scenario", "box_grasp", "--scenario", "box_grasp"): "--scenario = 'box_grasp'",
    ("tune", "free_bending"): "control.set_points = ",
    ("tune", "tip_distance_steps", "--set", "control.hold=-1"): "control.hold = -1",
    ("tune", "tip_distance_steps", "--evaluations=-5"): "--evaluations = '-5'",
    ("tune", "one_finger.yaml", "--set", "control.set_points=[0.1]"): "control: fingers = ['finger']",
    ("hardware", "--data", "nowhere", "--out", "results"): "--data = 'nowhere': there is no such folder",
    ("play", "free_bending", "--host", "192.0.2.1"): "192.0.2.1",
    ("run", "free_bending", "--meshcat", "--host", "192.0.2.1"): "host = '192.0.2.1'",
    ("calibrate", "none.nc", "--out", "."): "output: file = '.'",
    ("calibrate", "file", "--out", "new.yaml"): "file = 'file'",
}
CASES |= {
    (command, f"{kind}.{ending}"): f"{kind}.{ending}"
    for command, ending in (("run", "yaml"), ("show", "yaml"), ("expand", "urdf"))
    for kind in ("absent", "binary", "broken", "list", "empty")
}

# A number of an option: what it may not be.
_NUMBERS = {
    ("evaluate", "--jobs"): ("0", "-1", "two"),
    ("evaluate", "--seeds"): ("0", "many"),
    ("expand", "finger.urdf", "--segments"): ("0", "-3", "2.5", "many"),
    ("grasp-trials", "--trials"): ("0", "²", "٣", "100000000000"),
    ("grasp-trials", "--trial"): ("1.5",),
    ("grasp-trials", "--jobs"): ("0", "100000", "many"),
    ("grasp-trials", "--seed"): ("-1",),
    ("place-sensors", "--count"): ("0", "two"),
    ("place-sensors", "--count", "2", "--estimator"): ("splines",),
    ("place-sensors", "--count", "2", "--sensors"): ("perfect",),
    ("place-sensors", "--count", "2", "--nominal-error"): ("much", "100"),
    ("place-sensors", "--count", "2", "--seed"): ("-1",),
    ("sweep", "free_bending", "--out", "x", "--vary", "sensor.seed=1,2", "--jobs"): ("0",),
    ("sweep", "free_bending", "--out", "x", "--vary"): ("sensor.sections",),
    ("tune", "tip_distance_steps", "--evaluations"): ("many", "4", "7.5", "²"),
    ("run", "free_bending", "--set"): ("sensor.sections", "=3"),
}
CASES |= {(*line, value): f"{line[-1]} = {value!r}" for line, values in _NUMBERS.items() for value in values}
_SWEPT = {
    ("--vary", "sensor.nothing=1,2"): "--vary sensor.nothing: ",
    ("--vary", "sensor.sections=1,2", "--vary", "sensor.sections=3"): "appears more than once",
    ("--vary", "pressure.time_constant=0.01..0.1"): "give the number of values",
    ("--vary", "sensor.seed=1,2", "--method", "sobol"): "give --sample N",
    ("--vary", "sensor.seed=1,2", "--method", "grid", "--sample", "4"): "omit --sample",
}
CASES |= {("sweep", "free_bending", "--out", "x", *options): said for options, said in _SWEPT.items()}

# Where nothing can be written.
_RUN, _SHOW = ("run", "free_bending"), ("show", "free_bending")
CASES |= {
    (*_SHOW, "--graphviz", "file/blocks.dot"): "file = 'file/blocks.dot'",
    (*_SHOW, "--graphviz", "file/blocks.svg"): "file = 'file/blocks.svg'",
    (*_SHOW, "--graphviz", "blocks.bmp"): "--graphviz: FILE = 'blocks.bmp'",
    ("expand", "finger.urdf", "-o", "file/plain.urdf"): "file = 'file/plain.urdf'",
    (*_RUN, "--html", "file/animation.html"): "file = 'file/animation.html'",
    (*_RUN, "--video", "film.avi"): ("--video: FILE = 'film.avi'", ".mp4, .gif, .webp, .png"),
    **{(*_RUN, "--html", folder): "it is a folder; name a file" for folder in (".", "folder", "folder/", "/")},
    **{(*_RUN, "--video", folder): "--video: FILE = " for folder in (".", "folder", "folder/", "/")},
    **{
        (*_RUN, f"{option}={wrong}"): f"run: {option} = {wrong!r}"
        for option in ("--out", "--html", "--video")
        for wrong in ("", "~no_such_user/x")
    },
    **{
        (*line, "--out", "file/below"): "output: folder = 'file/below': cannot be written to"
        for line in (
            *(_RUN, ("evaluate",), ("place-sensors", "--count", "2")),
            ("sweep", "free_bending", "--vary", "sensor.seed=1,2"),
        )
    },
}

# A field of a scenario that is shipped.
_FIELDS: dict[str, dict[str, Said]] = {
    "free_bending": {
        "sensor.sectoins=3": ("sensor.sectoins = 3", "'sections'"),
        "sensr.sections=3": ("sensr = {'sections': 3}", "'sensor'"),
        "sensor.sections=2.5": "sensor.sections = 2.5",
        "sensor.sections=[1,": "sensor.sections = '[1,'",
        "sensor.period=0": "sensor.period = 0",
        "sensor.seed=" + "9" * 5000: "--set: sensor.seed = ",
        "models.0.segments=-1": "models[0].segments = -1",
        "models.0.file=nosuch.urdf": ("models[0]: file = ", "nosuch.urdf'"),
        "models.0.parent=hand::palm": "models[0]: parent = 'hand::palm'",
        "models.7.name=x": "key = 'models.7.name'",
        "models.first.name=x": "key = 'models.first.name'",
        "models.²=1": "--set: key = 'models.²'",
        "models=[]": "models = []",
        ".".join("a" * 3000) + "=1": "--set: key = ",
        "gravity=[0, 1]": "gravity = [0, 1]",
        "pressure.steps.all=[0, 9e9]": ("pressure.steps.all[1] = 9000000000.0", "-50000 to 210000 Pa"),
        "pressure.steps.all=[0, 210.1e3]": ("pressure.steps.all[1] = 210100.0", "-50000 to 210000 Pa"),
        "pressure.steps.left_finger=[-50.1e3]": ("pressure.steps.left_finger[0] = -50100.0", "-50000 to 210000 Pa"),
        "pressure.steps.all=[.nan]": "pressure.steps.all[0] = nan",
        "pressure.steps.left_fingr=[0]": "pressure.steps: left_fingr = [0.0]",
        "pressure.maximum=50e3": ("pressure.steps.all[1] = 60000.0", "-50000 to 50000 Pa"),
        "pressure.minimum=-102e3": ("pressure.minimum = '-102e3'", "-101325 Pa"),
        "pressure.maximum=.inf": ("pressure.maximum = inf", "finite"),
        "pressure.settle=-1": "pressure.settle = -1",
        "pressure.hold_samples=0": "pressure.hold_samples = 0",
        "plant_config.time_step=0.1": ("time_step = 0.1", "stable_time_step() = 0.013 s", "'left_finger'"),
        "plant_config.contact_model=sticky": "plant_config.contact_model = 'sticky'",
        "sensor.type=strian": ("sensor.type = 'strian'", "strain"),
        "sensor.type=math:pi": ("sensor.type = 'math:pi'", "callable"),
        "estimator.type=nowhere:make": ("estimator.type = 'nowhere:make'", "imported"),
        "nominal.lenght=0.1": ("nominal.lenght = '0.1'", "'length'"),
        "nominal.youngs_modulus=stiff": ("free_bending: nominal: youngs_modulus = 'stiff'", "+10 %"),
        "nominal.youngs_modulus=-100 %": ("nominal: finger", "left_finger", "base.youngs_modulus = 0.0"),
        "nominal.response=[[1, 0]]": "nominal.response = [[1.0, 0.0]]",
        "external=[pressur]": ("external[0] = 'pressur'", "pressure"),
        "simulator_config.integration_scheme=exact": ("integration_scheme = 'exact'", "cenic"),
    },
    "pick_and_place_box": {
        "arm.model=leg": ("arm.model = 'leg'", "gripper", "workbench", "box"),
        "arm.home=[0, 0, 0]": ("arm: home = [0.0, 0.0, 0.0]", "shoulder_pan_joint", "wrist_3_joint"),
        "arm.home=[0, 0, 7, 0, 0, 0]": ("arm.home: elbow_joint = 7.0", "3.14159"),
        "models.0.file={here}/limp.urdf": (
            "limp.urdf",
            "shoulder",
            "limit.effort = 0.0",
            "arm.limits.shoulder",
            "velocity",
        ),
        "models.1.parent=arm::tol0": ("models[1]: parent = 'arm::tol0'", "tool0"),
        "models.1.parent=world": ("model = 'arm'", "does not carry the gripper"),
        "models.1.file=package://soft_gripper/objects/box.sdf": ("fingers = []", "two fingers"),
        "models.3.X_PC.translation=[2, 0, 0.04]": ("task.phases[0]", "to = 'object'", "reach"),
        "task.object=bx": ("task.object = 'bx'", "box"),
        "task.X_WGoal.translation=[0.45, 3, 0.04]": ("task.phases[4]", "to = 'goal'", "reach"),
        "task.phases.1.to=objct": ("task.phases[1].to = 'objct'", "object"),
        "task.phases.1.spd=2": ("task.phases[1].spd = 2", "'speed'"),
        "task.phases.1.height=-0.1": ("task.phases[1]", "name = 'descend'", "workbench"),
        "task.phases.4.height=4294967296": ("task.phases[4]", "to = 'goal'", "reach"),
        "control.torque_limit=-1": "control.torque_limit = -1",
        "estimator.contact_threshold=-1": "estimator.contact_threshold = -1",
    },
}
CASES |= {
    ("run", name, *short(override)) if name == "free_bending" else ("run", name, "--set", override): said
    for name, fields in _FIELDS.items()
    for override, said in fields.items()
}


def _scenario(text: str) -> str:
    """The file of a scenario."""
    name = f"s{len(FILES)}.yaml"
    FILES[name] = text
    return name


def _named(file: str, said: Said) -> tuple[str, ...]:
    return (f"{file}: ", *([said] if isinstance(said, str) else said))


# Below the models of a scenario; instead of its only model; of an object in it.
_TEXTS = {
    "arm: {1: 2}": "arm = 1",
    "2001-01-01: 3": "key = ",
    "? \n: 3": "key = None",
    "sensor: !foo {sections: 2}": "sensor = '!foo'",
    "sensor: {seed: " + "9" * 5000 + "}": "file = ",
    "gravity: " + "[" * 3000 + "]" * 3000: "depth = 41",
    "task: {X_OG: {translation: [.inf, 0, 0]}}": "task.X_OG.translation[0] = inf",
    "sensor: {response: [[1, 0], [1.000000000000001, 1]]}": "sensor.response = ",
    "plant_config: {time_step: 1.0e-12}": "plant_config.time_step = 1e-12",
}
_MODELS = {
    "{name: f, file: finger.urdf, X_PC: {base_frame: here}}": "models[0].X_PC.base_frame = 'here'",
    "{name: f, file: finger.urdf, X_PC: {rotation: !AngleAxis {angle_deg: 3, axis: [0, 0, 0]}}}": "rotation = '!Angle",
    "{name: f, file: finger.urdf, X_PC: {rotation: !Uniform {}}}": "rotation = '!Uniform'",
    '{name: f, file: "a\\0b.urdf"}': "models[0].file = ",
    f"{{name: f, file: {_LONG}.urdf}}": "models[0]: file = ",
    "{name: f, file: loop.urdf}": "models[0]: file = ",
    "{name: f, file: pipe.urdf}": "models[0]: file = ",
    "{name: a.b, file: finger.urdf}": "models[0].name = 'a.b'",
    f"{{name: {_LONG}, file: finger.urdf}}": "models[0].name = ",
    "{name: f, file: package://soft_gripper/../x.urdf}": "model: file = 'package://soft_gripper/../x.urdf'",
}
_OBJECTS = {
    "bare.urdf": ('<robot name="r"/>', "models[1]: file = "),
    "zero.urdf": (_LINK.format('<geometry><box size="0 1 1"/></geometry>'), "link 'l': box.size = '0 1 1'"),
    "nan.urdf": (_LINK.format('<geometry><box size="nan 1 1"/></geometry>'), "link 'l': box.size = 'nan 1 1'"),
    "words.urdf": (_LINK.format('<origin xyz="a b"/>'), "link 'l': origin.xyz = 'a b'"),
    "bomb.urdf": ('<!DOCTYPE r [<!ENTITY a "aa">]><robot name="&a;"/>', "bomb.urdf: DOCTYPE = 'r'"),
    "secret.sdf": ('<!DOCTYPE r [<!ENTITY a SYSTEM "s.yaml">]><sdf/>', "secret.sdf: DOCTYPE = 'r'"),
    "nan.sdf": (_SDF.format("<inertial><inertia><ixx>nan</ixx></inertia></inertial>"), "link 'l': inertia.ixx = 'nan'"),
    "latin.sdf": (_SDF.format("<!-- \xe9 -->").encode("latin-1"), "latin.sdf: file = 'latin.sdf': cannot be read"),
    "ring.urdf": (f'<robot name="r"><link name="a"/><link name="b"/>{_RING}</robot>', "parent, child = 'b, a'"),
}
for _text, _said in _TEXTS.items():
    _file = _scenario("models: [{name: f, file: finger.urdf}]\n" + _text)
    CASES["run", _file] = _named(_file, _said)
CASES |= {("run", _scenario(f"models:\n- {model}\n")): said for model, said in _MODELS.items()}
for _file, (_content, _said) in _OBJECTS.items():
    FILES[_file] = _content
    CASES["run", _scenario(f"models: [{{name: f, file: finger.urdf}}, {{name: o, file: {_file}}}]")] = _said

# A text of a finger that is replaced by another.
_FINGERS: dict[tuple[str, str], Said] = {
    ('thickness="0.02"', 'thickness="-0.02"'): "base.thickness = -0.02",
    ('youngs_modulus="2.67e5"', 'youngs_modulus="-8e5"'): "base.youngs_modulus = -800000.0",
    ('youngs_modulus="2.67e5"', 'youngs_modulus="soft"'): "base.youngs_modulus = 'soft'",
    ('length="0.12"', 'length="nan"'): "body.length = 'nan'",
    ('length="0.12"', 'length="5e-324"'): "body.length = 5e-324: ",
    ('width="0.02"', 'width="1e308"'): "base.width = 1e+308: ",
    ('segments="12"', 'segments="0"'): "body.segments = 0",
    ('segments="12"', 'segments="2.5"'): "body.segments = '2.5'",
    ('segments="12"', 'segments="2000"'): "body.segments = 2000: ",
    (' density="1070"', ""): ("base.density = None", "missing"),
    ("density", "densty"): ("<base>: attribute = 'densty'", "'density'"),
    ('<sensors spacing="0.017"/>', ""): ("sensors = None", "missing"),
    ("<sensors", "<sensor"): ("element = 'sensor'", "sensors"),
    ('<parent link="mount"/>', '<parent link="hand"/>'): ("parent.link = 'hand'", "mount"),
}
for _i, ((_text, _wrong), _said) in enumerate(_FINGERS.items()):
    assert _text in FINGER
    FILES[f"finger_{_i}.urdf"] = FINGER.replace(_text, _wrong)
    CASES["expand", f"finger_{_i}.urdf", "-o", "plain.urdf"] = _named(f"finger_{_i}.urdf", _said)
    CASES["run", _scenario(f"models: [{{name: index, file: finger_{_i}.urdf}}]")] = _said
