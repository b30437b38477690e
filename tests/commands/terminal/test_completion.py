"""Completion, as bash does it."""

import shutil
import subprocess

import pytest

from soft_gripper.commands.dispatch import command_parser

BASH = shutil.which("bash")


def completed(script, *words):
    line = " ".join(f"'{word}'" for word in words)
    ask = f"COMP_WORDS=(soft-gripper {line}); COMP_CWORD={len(words)}; _shtab_soft_gripper"
    lines = [script, ask, 'printf "%s\\n" "${COMPREPLY[@]}"']
    return set(
        subprocess.run([BASH, "-c", "\n".join(lines)], capture_output=True, text=True, check=True).stdout.split()
    )


@pytest.mark.skipif(BASH is None, reason="needs bash")
def test_bash_completes_commands_scenarios_and_options(capsys):
    with pytest.raises(SystemExit):
        command_parser().parse_args(["--print-completion", "bash"])
    script = capsys.readouterr().out
    assert completed(script, "ev") == {"evaluate"}
    assert "box_grasp" in completed(script, "run", "box")
    assert completed(script, "run", "--mesh") == {"--meshcat"}
