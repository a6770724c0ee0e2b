"""Fit captures of knobs, and print their parameters side by side.

    python fit_and_compare.py captures/*.mcap
"""

import sys

import haptic_camera as hc


def row(path: str) -> dict[str, float | None]:
    """A capture's parameters by name; None where the data cannot tell one."""
    fit = hc.fit(path)
    return {name: parameter.value for name, parameter in fit.parameters.items()}


def main(paths: list[str]) -> None:
    rows = {path: row(path) for path in paths}
    names = sorted({name for values in rows.values() for name in values})
    for name in names:
        estimates = (values.get(name) for values in rows.values())
        print(f"{name:20}", *(f"{value:12.5g}" if value is not None else f"{'–':>12}" for value in estimates))


if __name__ == "__main__":
    main(sys.argv[1:])
