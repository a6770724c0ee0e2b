"""The command line called on recordings, and counts of what it said."""

import json
import subprocess


def called(program, arguments, json_file):
    """The JSON of a command; `None` where it ended in an error."""
    json_file.unlink(missing_ok=True)
    subprocess.run([program, *arguments, "--json", json_file], capture_output=True, check=False)
    return json.loads(json_file.read_text()) if json_file.exists() else None


def percent(hits, of):
    return f"{hits} of {of}, {100 * hits / of:.0f} %" if of else "–"


def added(counts, keys, more):
    """Adds to the counts of every key."""
    for key in keys:
        counts[key] = [sum(pair) for pair in zip(counts[key], more)]
