"""Is the folder of an exported run a valid RO-Crate 1.3 and a Process Run Crate? Asks rocrate-validator, which knows the
profile's rules as of 0.5, and runcrate, which reads what was done.

The JSON-LD context of RO-Crate 1.3, which both would fetch, is the one that the package rocrate has: no network is needed.
"""

import io
import json
import pathlib
import subprocess
import sys

import rdflib.plugins.shared.jsonld.context as jsonld
import requests
import rocrate
import urllib3
from rocrate.rocrate import ROCrate
from rocrate_validator import services

CONTEXT = "https://w3id.org/ro/crate/1.3/context"
context = (pathlib.Path(rocrate.__file__).parent / "data" / "ro-crate.jsonld").read_bytes()
assert json.loads(context)["@id"] == CONTEXT

fetch, send = jsonld.source_to_json, requests.adapters.HTTPAdapter.send


def source_to_json(source, *arguments, **options):
    if str(source) == CONTEXT:
        return json.loads(context), None
    return fetch(source, *arguments, **options)


def from_package(adapter, request, **options):
    if request.url != CONTEXT:
        return send(adapter, request, **options)
    headers = {"Content-Type": "application/ld+json"}
    body = io.BytesIO(context)
    return adapter.build_response(request, urllib3.HTTPResponse(body, headers, 200, preload_content=False))


jsonld.source_to_json, requests.adapters.HTTPAdapter.send = source_to_json, from_package

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
