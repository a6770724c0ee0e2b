"""Puts the breakaway torques that a creep showed into a fitted model; called by scripts/study-knobs.

A fast sweep passes the stick within a sample or two and reads it low; a creep winds up slowly to where it gives way,
which is the top of the rectangle that the paper reads off by hand.

    python3 scripts/take-breakaways.py MODEL.toml CHECK.json
"""

import json
import re
import sys
from pathlib import Path

model, check = Path(sys.argv[1]), json.loads(Path(sys.argv[2]).read_text())
text = model.read_text()
for seen in check["agreement"]:
    name = seen["quantity"]
    # What a resting knob bears is above zero: where the interval is not, lost motion or chance made the reading.
    if name in ("static_negative", "static_positive") and seen["ci95"] and seen["ci95"][0] > 0:
        text = re.sub(rf"^{name} = \S+", f"{name} = {seen['checked']:.6g}", text, flags=re.MULTILINE)
model.write_text(text)
