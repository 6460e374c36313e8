"""Is the folder of an exported run a valid RO-Crate 1.3 and a Process Run Crate? Asks rocrate-validator, which knows the
profile's rules as of 0.5, and runcrate, which reads what was done.

Where the JSON-LD context of RO-Crate cannot be fetched, the rules are not checked, and the words at the end say so.
"""

import pathlib
import subprocess
import sys

import requests
from rocrate.rocrate import ROCrate
from rocrate_validator import services

folder = sys.argv[1]

crate = ROCrate(folder)
actions = [entity for entity in crate.contextual_entities if entity.type == "CreateAction"]
assert len(actions) == 3, actions
for action in actions:
    assert action["instrument"]["name"] == "vesica", action
    files = []
    for part in [action["result"], action["object"]]:
        assert part, action
        files += part if isinstance(part, list) else [part]
    for file in files:
        assert (pathlib.Path(folder) / file["name"]).is_file(), file

report = subprocess.run(
    [pathlib.Path(sys.executable).parent / "runcrate", "report", folder], capture_output=True, text=True
)
assert report.returncode == 0, report.stderr
assert report.stdout.count("action: #session-") == 2, report.stdout

failed = False
try:
    requests.get("https://w3id.org/ro/crate/1.3/context", timeout=20).raise_for_status()
except requests.RequestException as error:
    print(f"the rules are not checked, for the context of RO-Crate cannot be fetched: {error}")
    sys.exit(0)
for profile, inherits in [("ro-crate-1.3", True), ("process-run-crate-0.5", False)]:
    result = services.validate(
        {
            "rocrate_uri": folder,
            "profile_identifier": profile,
            "enable_profile_inheritance": inherits,
            "requirement_severity": "REQUIRED",
        }
    )
    for issue in result.get_issues():
        failed = True
        print(f"{profile}: {issue.check.identifier}: {issue.message}")
sys.exit(failed)
