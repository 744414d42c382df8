"""Print the project's requirements and those of the extras named (`dev` by default), for `pip install -r`."""

import sys
import tomllib
from pathlib import Path

project = tomllib.loads((Path(__file__).parent.parent / "pyproject.toml").read_text())["project"]
extras = project["optional-dependencies"]
print(
    "\n".join(
        [*project["dependencies"], *(line for name in sys.argv[1:] or ["dev"] for line in extras[name])]
    )
)
