"""The Flamenco job type, compiled by a JavaScript runtime against Flamenco's interface."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

FARMS = Path(__file__).resolve().parents[2] / "tools" / "farms"
SCRIPT = FARMS / "flamenco" / "umbilics.js"

# What Flamenco's Manager gives to a job compiler script: `author`, with tasks that take commands
# and dependencies, and a job that takes tasks. Nothing else is there, as in the Manager. See
# https://flamenco.blender.org/usage/job-types/ and, for "exec",
# https://flamenco.blender.org/usage/jobs-tasks-commands/commands/
HARNESS = """
const tasks = [];
class Task {
    constructor(name, type) { this.name = name; this.type = type;
                              this.commands = []; this.needs = []; }
    addCommand(command) { this.commands.push(command); }
    addDependency(task) { this.needs.push(task.name); }
}
const author = {
    Task: (name, type) => new Task(name, type),
    Command: (name, parameters) => ({ name, parameters }),
};
const job = { settings: SETTINGS, addTask: (task) => tasks.push(task) };
const context = require("vm").createContext({ author, print: () => {} });
const source = require("fs").readFileSync(process.argv[2], "utf8");
const vm = require("vm");
vm.runInContext(source + "; this.JOB_TYPE = JOB_TYPE; this.compileJob = compileJob;", context);
let error = null;
try { context.compileJob(job); } catch (reason) { error = String(reason); }
console.log(JSON.stringify({ type: context.JOB_TYPE, tasks, error }));
"""


def compiled(tmp_path, **settings):
    node = shutil.which("node") or shutil.which("nodejs")
    if node is None:
        pytest.skip("needs a JavaScript runtime: node")
    harness = tmp_path / "harness.js"
    harness.write_text(HARNESS.replace("SETTINGS", json.dumps(settings)))
    done = subprocess.run([node, harness, SCRIPT], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


SETTINGS = {"meshes": "/shared/in", "results": "/shared/out", "parts": 3}


def test_the_settings_are_ones_that_flamenco_knows(tmp_path):
    job_type = compiled(tmp_path, **SETTINGS)["type"]
    assert job_type["label"]
    known = {"key", "type", "subtype", "choices", "propargs", "description", "default", "eval",
             "evalInfo", "visible", "required", "editable", "label"}  # fmt: skip
    for setting in job_type["settings"]:
        assert set(setting) <= known
        assert re.fullmatch(r"[a-z_]+", setting["key"])
        assert setting["type"] in ("string", "int32", "float", "bool")
        assert setting.get("subtype", "dir_path") in ("file_path", "dir_path", "file_name")
        assert setting.get("visible", "visible") in ("visible", "hidden", "submission", "web")


def test_the_folder_is_dealt_out_and_a_summary_waits_for_all_parts(tmp_path):
    tasks = compiled(tmp_path, **SETTINGS, also="png  ply", options="--opening 2", jobs=4)["tasks"]
    assert [task["name"] for task in tasks] == [
        "part-1-of-3", "part-2-of-3", "part-3-of-3", "summary",
    ]  # fmt: skip
    assert {task["type"] for task in tasks} == {"blender"}
    assert tasks[-1]["needs"] == ["part-1-of-3", "part-2-of-3", "part-3-of-3"]
    for task in tasks:
        (command,) = task["commands"]
        assert command["name"] == "exec"
        assert command["parameters"]["exe"] == "{blender}"
        assert all(isinstance(argument, str) for argument in command["parameters"]["args"])
    assert tasks[1]["commands"][0]["parameters"]["args"] == [
        *("-b", "--command", "umbilics", "/shared/in", "--out", "/shared/out"),
        *("--resume", "--tolerant", "--part", "2/3", "--jobs", "4", "--also", "png"),
        *("--also", "ply", "--opening", "2"),
    ]
    assert tasks[-1]["commands"][0]["parameters"]["args"] == [
        *("-b", "--command", "umbilics", "--out", "/shared/out", "--summary"),
    ]


def test_no_parts_are_refused(tmp_path):
    assert "parts" in compiled(tmp_path, **(SETTINGS | {"parts": 0}))["error"]
