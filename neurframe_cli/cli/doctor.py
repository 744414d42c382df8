"""`neurframe doctor`: what is installed, which executables, which device, and a self-test of a few seconds."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import click

from neurframe_cli.cli.command import StageCommand
from neurframe_cli.errors import StageError

if TYPE_CHECKING:
    from neurframe_cli.cli.console import Console


@click.command(name="doctor", cls=StageCommand)
@click.option("--json", "as_json", is_flag=True, help="Print the findings as one JSON object.")
def command(as_json: bool, threads: int, console: Console) -> None:
    """What is installed here, which device will be used, and does it work."""
    from neurframe_cli.pipeline.doctor import examine

    findings = examine(threads)
    if as_json:
        console.result(json.dumps([finding.__dict__ for finding in findings], indent=1))
    else:
        width = max(len(finding.name) for finding in findings)
        for finding in findings:
            console.result(f"{'ok  ' if finding.ok else 'FAIL'}  {finding.name:<{width}}  {finding.detail}")
    failed = [finding.name for finding in findings if finding.required and not finding.ok]
    if failed:
        raise StageError(
            f"not working: {', '.join(failed)}", hint="install neurframe again in a fresh environment"
        )
