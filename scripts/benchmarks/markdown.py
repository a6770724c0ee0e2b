"""Tables and goals as Markdown, printed and kept."""

import os
import platform
from pathlib import Path


def table(heads, rows):
    """A Markdown table: the first column left, the others right."""
    lines = ["| " + " | ".join(heads) + " |", "|---|" + "---:|" * (len(heads) - 1)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def microseconds(value_us):
    """About three figures that count, down to nanoseconds."""
    return f"{value_us:.0f}" if value_us >= 100 else f"{value_us:.1f}" if value_us >= 10 else f"{value_us:.3f}"


def goal(name, figure, bar, met):
    """A row of the table of goals; whether it is met is computed by the caller from the figure and the bar."""
    return [name, figure, bar, "met" if met else "**missed**"]


def goals_table(rows):
    return table(["goal", "figure", "bar", ""], rows)


def machine():
    """What the figures were taken on."""
    model = next((line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")), "?")
    load = os.getloadavg()[0]
    return f"{model}, {os.cpu_count()} processors, Linux {platform.release()}; load average at the start {load:.2f}"


def keep(name, text):
    """Prints the text and keeps it in target/bench/NAME.md."""
    path = Path("target/bench") / f"{name}.md"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text + "\n")
    print(f"\n{text}\n\nkept in {path}", flush=True)
