"""The command line: exit codes, one clear line for bad input, options from files, nothing heavy for --help."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import click
import pytest

from neurframe_cli.cli.command import StageCommand
from neurframe_cli.cli.configuration import defaults_for
from neurframe_cli.cli.main import COMMANDS, group, run_command_line

HEAVY = ("numpy", "scipy", "torch", "trimesh", "pyvista", "meshio", "igl", "rich")


def run(*arguments: str, cwd: Path | None = None, **environment: str) -> subprocess.CompletedProcess[str]:
    """`neurframe ARGUMENTS` in a process of its own."""
    return subprocess.run(
        [sys.executable, "-m", "neurframe_cli", *arguments],
        cwd=cwd,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
    )


def test_help_loads_nothing_heavy() -> None:
    script = (
        "import sys; from neurframe_cli.cli.main import run_command_line as go; go(['--help']);"
        f"print([m for m in {HEAVY} if m in sys.modules])"
    )
    shown = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout
    assert shown.splitlines()[-1] == "[]"
    assert all(name in shown for name in COMMANDS)


@pytest.mark.parametrize("name", list(COMMANDS))
def test_every_command_explains_itself(name: str) -> None:
    command = group.get_command(click.Context(group), name)
    assert isinstance(command, StageCommand)
    assert command.name == name
    assert command.help
    assert all(p.help for p in command.params if isinstance(p, click.Option))


@pytest.mark.parametrize(
    ("arguments", "code", "says"),
    [
        (["no-such-command"], 2, "No such command"),
        (["tetize"], 2, "Missing argument"),
        (["tetize", "missing.stl"], 2, "missing.stl"),
        (["train"], 2, "no workspace here"),
        (["train", "-w", "nowhere"], 2, "nowhere"),
        (["discretize", "--no-such-option"], 2, "--no-such-option"),
        (["--config", "missing.toml", "train"], 2, "missing.toml"),
        (["train", "--sigma", "inf"], 2, "not a finite number"),
        (["hex", "--scale", "nan"], 2, "not a finite number"),
    ],
)
def test_wrong_usage_is_one_clear_line(tmp_path: Path, arguments: list[str], code: int, says: str) -> None:
    ended = run(*arguments, cwd=tmp_path)
    assert ended.returncode == code
    assert says in ended.stderr
    assert "Traceback" not in ended.stderr
    assert list(tmp_path.glob("*.neurframe")) == []


def test_unusable_input_leaves_the_reason_in_the_manifest(tmp_path: Path) -> None:
    (tmp_path / "bad.stl").write_text("this is not a mesh")
    ended = run("tetize", "bad.stl", cwd=tmp_path)
    assert ended.returncode == 2
    assert "bad.stl" in ended.stderr
    assert "Traceback" not in ended.stderr
    record = json.loads((tmp_path / "bad.neurframe" / "manifest.json").read_text())["stages"]["tetize"]
    assert record["status"] == "failed"
    assert "bad.stl" in record["error"]


def test_config_file_sets_defaults_and_the_command_line_wins(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("neurframe.toml").write_text("[tetize]\nedge-length = 0.1\nseed = 7\n")
    command = group.get_command(click.Context(group), "tetize")
    assert command is not None
    parent = click.Context(group)
    context = command.make_context("tetize", ["part.stl", "--seed", "3"], parent)
    assert context.params["tet_edge_length"] == 0.1
    assert context.params["seed"] == 3


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[tetize]\nedge-lenght = 0.1\n", "edge-lenght"),
        ("[tetise]\nedge-length = 0.1\n", "tetise"),
        ("edge-length = 0.1\n", "outside a table"),
        ("[tetize\n", "not valid TOML"),
        ('[tetize]\nedge-length = "wide"\n', "takes no str"),
        ("[tetize]\nseed = 1.7\n", "takes no float"),
        ("[tetize]\nseed = true\n", "takes no bool"),
        ("[tetize]\nfeatures = [1]\n", "takes no list"),
        ('[executables]\nmiqq = "x"\n', "no program 'miqq'"),
        ('[executables]\nmiq = "no/such/file"\n', "not an executable file"),
    ],
)
def test_mistakes_in_a_config_file_are_named(tmp_path: Path, text: str, says: str) -> None:
    (tmp_path / "neurframe.toml").write_text(text)
    ended = run("tetize", "part.stl", cwd=tmp_path)
    assert ended.returncode == 2
    assert says in ended.stderr
    assert "Traceback" not in ended.stderr


@pytest.mark.parametrize(
    ("command", "arguments", "folder"),
    [
        ("tetize", ["part.stl"], "part.neurframe"),
        ("train", [], "part.neurframe"),
        ("train", [], "."),
        ("train", ["-w", "elsewhere"], "elsewhere"),
        ("train", ["-welsewhere"], "elsewhere"),
    ],
)
def test_config_file_of_the_workspace_in_use_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str, arguments: list[str], folder: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path(folder).mkdir(exist_ok=True)
    (Path(folder) / "manifest.json").touch()
    (Path(folder) / "neurframe.toml").write_text(f"[{command}]\nseed = 7\n")
    found = group.get_command(click.Context(group), command)
    assert found is not None
    assert found.make_context(command, arguments, click.Context(group)).params["seed"] == 7


def test_config_file_names_executables_and_the_environment_beats_it(tmp_path: Path) -> None:
    for name in ("mine", "other"):
        (tmp_path / name).write_text(f"#!/bin/sh\necho {name} 1.0\n")
        (tmp_path / name).chmod(0o755)
    (tmp_path / "neurframe.toml").write_text('[executables]\nmiq = "./mine"\n')
    assert says_of_miq(tmp_path) == "mine 1.0"
    assert says_of_miq(tmp_path, NEURFRAME_MIQ=str(tmp_path / "other")) == "other 1.0"


def says_of_miq(folder: Path, **environment: str) -> str:
    script = (
        "from pathlib import Path; from neurframe_cli.cli.configuration import configured_executables as use;"
        "from neurframe_cli.pipeline.executables import find_executable; import subprocess\n"
        "with use([Path('neurframe.toml')]): subprocess.run([find_executable('miq')])"
    )
    shown = subprocess.run(
        [sys.executable, "-c", script],
        cwd=folder,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=True,
    )
    return shown.stdout.strip()


def test_dumped_options_are_the_defaults_and_are_read_back(tmp_path: Path) -> None:
    dumped = run("config", "--dump", cwd=tmp_path).stdout
    path = tmp_path / "all.toml"
    path.write_text(dumped)
    assert tomllib.loads(dumped).keys() == {*COMMANDS, "executables"}
    for name in COMMANDS:
        command = group.get_command(click.Context(group), name)
        assert command is not None
        context = click.Context(command)
        for key, value in defaults_for(command, [path], list(COMMANDS)).items():
            option = next(p for p in command.params if p.name == key)
            assert value == option.get_default(context), (name, key)
    assert run("--config", str(path), "config", "--dump", cwd=tmp_path).stdout == dumped


def test_dump_shows_what_config_files_say(tmp_path: Path) -> None:
    (tmp_path / "neurframe.toml").write_text('[tetize]\nedge-length = 0.125\nfeatures = "a \\"b\\" ü.json"\n')
    dumped = tomllib.loads(run("config", "--dump", cwd=tmp_path).stdout)
    assert dumped["tetize"]["edge-length"] == 0.125
    assert dumped["tetize"]["features"] == 'a "b" ü.json'
    assert run("config", cwd=tmp_path).stdout.strip() == "neurframe.toml"


def test_bash_completes_commands_options_and_values(tmp_path: Path) -> None:
    (tmp_path / "neurframe").write_text(f'#!/bin/sh\nexec {sys.executable} -m neurframe_cli "$@"\n')
    (tmp_path / "neurframe").chmod(0o755)
    script = """
        eval "$(neurframe completion bash)"
        ask() { COMPREPLY=()
                COMP_WORDS=(neurframe "$@"); COMP_CWORD=$#; _neurframe_completion neurframe; echo "${COMPREPLY[*]}"; }
        ask disc; ask hex --target; ask train --preset ""
    """
    shown = subprocess.run(
        ["bash", "-c", script],
        env={**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert shown.stdout.splitlines() == ["discretize", "--target-cells", "fast paper"]


@pytest.mark.parametrize("shell", ["zsh", "fish"])
def test_completion_scripts_of_the_other_shells_call_us(
    shell: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run_command_line(["completion", shell]) == 0
    assert f"_NEURFRAME_COMPLETE={shell}_complete" in capsys.readouterr().out


def test_output_that_nobody_reads_is_no_failure() -> None:
    reader, writer = os.pipe()
    os.close(reader)
    ended = subprocess.run(
        [sys.executable, "-m", "neurframe_cli", "--help"],
        stdout=writer,
        stderr=subprocess.PIPE,
        text=True,
        check=False,
    )
    os.close(writer)
    assert (ended.returncode, ended.stderr) == (0, "")


def test_log_json_has_one_record_a_line(tmp_path: Path) -> None:
    run("train", "-w", "nowhere", "--log-json", "log.jsonl", cwd=tmp_path)
    records = [json.loads(line) for line in (tmp_path / "log.jsonl").read_text().splitlines()]
    assert all({"time", "level", "message"} <= record.keys() for record in records)
    assert "nowhere" in records[-1]["message"]


def test_internal_errors_are_one_line_and_the_traceback_is_for_those_who_ask(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def broken(*args: object, **kwargs: object) -> None:
        raise ZeroDivisionError("what a pity")

    monkeypatch.setattr(group, "make_context", broken)
    assert run_command_line([]) == 3
    assert "internal error" in capsys.readouterr().err
    monkeypatch.setenv("NEURFRAME_DEBUG", "1")
    assert run_command_line([]) == 3
    assert "Traceback" in capsys.readouterr().err
