"""Completion, as bash does it."""

import shutil
import subprocess

import pytest

from soft_gripper.commands.parser import command_parser

BASH = shutil.which("bash")


def completed(script, *words):
    line = " ".join(f"'{word}'" for word in words)
    ask = f"COMP_WORDS=(soft-gripper {line}); COMP_CWORD={len(words)}; _shtab_soft_gripper"
    lines = [script, ask, 'printf "%s\\n" "${COMPREPLY[@]}"']
    return set(
        subprocess.run([BASH, "-c", "\n".join(lines)], capture_output=True, text=True, check=True).stdout.split()
    )


@pytest.mark.skipif(BASH is None, reason="needs bash")
def test_bash_completes_commands_scenarios_options_and_files(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("own.yaml", "own_results"):
        (tmp_path / name).touch()
    with pytest.raises(SystemExit):
        command_parser().parse_args(["--print-completion", "bash"])
    script = capsys.readouterr().out
    assert completed(script, "ex") >= {"expand"}
    assert "box_grasp" in completed(script, "run", "box")
    assert completed(script, "run", "--mesh") == {"--meshcat"}
    assert completed(script, "run", "own") == {"own.yaml", "own_results"}
    assert completed(script, "run", "--out", "own_") == {"own_results"}
