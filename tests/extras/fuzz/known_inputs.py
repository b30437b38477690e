"""Hostile and mistaken input that is known: files, and commands with what they must say of it."""

from pathlib import Path

from command_line import short

from soft_gripper.models import DIRECTORY

Said = str | tuple[str, ...]

FINGER = (DIRECTORY / "grippers/finger.urdf").read_text()
_LIMP = """<robot name="limp"><link name="base_link"/><link name="tool0"/><joint name="shoulder" type="revolute">
<parent link="base_link"/><child link="tool0"/><limit velocity="0" effort="0"/></joint></robot>"""
_LONG = "n" * 300

FILES: dict[str, str | bytes] = {  # beside them: loop.urdf, a link to itself, pipe.urdf, which is one, and a folder
    "file": "a file, below which nothing can be written, not even by root",
    "finger.urdf": FINGER,
    "one_finger.yaml": (Path(__file__).parents[2] / "scenarios/defaults.yaml").read_text(),
    "limp.urdf": _LIMP,
    "no_finger.urdf": "<robot name='plain'><link name='base'/></robot>",
    "bench.yaml": "source: 'udp://:5005'\nfingers: {finger: {readings: [a]}}\n",
    **{f"binary.{ending}": b"\xff\xfe\x00" for ending in ("yaml", "urdf")},
    **{f"broken.{ending}": "a: [1" for ending in ("yaml", "urdf")},
    **{f"list.{ending}": "- 1" for ending in ("yaml", "urdf")},
    **{f"empty.{ending}": "" for ending in ("yaml", "urdf")},
}
# What options may not be, one by one, is in tests/commands; what fields may not be, in tests/files and tests/scenario;
# what texts and files of models may not be, in tests/files and tests/model_import.
CASES: dict[tuple[str, ...], Said] = {
    ("run", "free_bendig"): ("name = 'free_bendig'", "free_bending"),
    ("run", "free_bending", "--sections", "99"): "sections = 99",
    ("expand", "no_finger.urdf"): ("no_finger.urdf", "finger"),
    ("show", f"{_LONG}.yaml"): "scenario = ",
    ("show", "bench.yaml"): ("bench.yaml: source = ", "seems to be a description of a bench"),
    ("live", "free_bending", "--bench", "one_finger.yaml"): ("one_finger.yaml: ", "seems to be a scenario"),
    ("design", "one_finger.yaml"): ("one_finger.yaml: ", "seems to be a scenario"),
    ("study", "grasp-trials", "--scenario", "box_grasp"): "task = None: give a task for the trials",
    ("tune", "free_bending"): "control.set_points = ",
    ("tune", "one_finger.yaml", "--set", "control.set_points=[0.1]"): "control: fingers = ['finger']",
    ("play", "free_bending", "--host", "192.0.2.1"): "192.0.2.1",
    ("run", "free_bending", "--meshcat", "--host", "192.0.2.1"): "host = '192.0.2.1'",
    ("calibrate", "none.nc", "--out", "."): "output: file = '.'",
    ("calibrate", "file", "--out", "new.yaml"): "file = 'file'",
}
CASES |= {
    (command, f"{kind}.{ending}"): f"{kind}.{ending}"
    for command, ending in (("show", "yaml"), ("expand", "urdf"))
    for kind in ("absent", "binary", "broken", "list", "empty")
}
# Where nothing can be written.
_RUN = "run", "free_bending"
CASES |= {
    ("show", "free_bending", "--graphviz", "blocks.bmp"): "--graphviz: FILE = 'blocks.bmp'",
    (*_RUN, "--video", "film.avi"): ("--video: FILE = 'film.avi'", ".mp4, .gif, .webp, .png"),
    **{(*_RUN, "--html", folder): "it is a folder; name a file" for folder in (".", "folder", "folder/", "/")},
    **{(*_RUN, "--video", folder): "--video: FILE = " for folder in (".", "folder/")},
}

# A field of a scenario that is shipped.
_FIELDS: dict[str, dict[str, Said]] = {
    "free_bending": {
        "sensor.response=[[1, 0], [1.000000000000001, 1]]": "sensor.response = ",
        "models.0.file=nosuch.urdf": ("models[0]: file = ", "nosuch.urdf'"),
        "models.0.parent=hand::palm": "models[0]: parent = 'hand::palm'",
        "plant_config.time_step=0.1": ("time_step = 0.1", "stable_time_step() = 0.013 s", "'left_finger'"),
        "sensor.type=math:pi": ("sensor.type = 'math:pi'", "callable"),
    },
    "pick_and_place_box": {
        "models.0.file={here}/limp.urdf": ("limp.urdf", "shoulder", "limit.effort = 0.0", "arm.limits", "velocity"),
        "models.1.parent=world": ("model = 'arm'", "does not carry the gripper"),
        "models.1.file=package://soft_gripper/objects/box.sdf": ("fingers = []", "two fingers"),
        "task.phases.4.height=4294967296": ("task.phases[4]", "to = 'goal'", "reach"),
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


# Instead of the only model of a scenario.
_MODELS = {
    "{name: f, file: finger.urdf, X_PC: {rotation: !Uniform {}}}": "rotation = '!Uniform'",
    '{name: f, file: "a\\0b.urdf"}': "models[0].file = ",
    f"{{name: f, file: {_LONG}.urdf}}": "models[0]: file = ",
    "{name: f, file: loop.urdf}": "models[0]: file = ",
    "{name: f, file: pipe.urdf}": "models[0]: file = ",
    "{name: f, file: package://soft_gripper/../x.urdf}": "model: file = 'package://soft_gripper/../x.urdf'",
}
CASES |= {("run", _scenario(f"models:\n- {model}\n")): said for model, said in _MODELS.items()}
