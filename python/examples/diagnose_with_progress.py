"""Name what a model of a capture lacks, telling how far the search has come.

    python diagnose_with_progress.py TRAIN HELDOUT
"""

import sys

import haptic_camera as hc


def tell(progress: hc.Progress) -> None:
    if progress.heldout_over_floor is None:
        print(f"\rtried {progress.done} of {progress.of}", end="", flush=True)
    else:
        print(f"\radded {progress.effect}: {progress.heldout_over_floor:.2f} times the noise is left")


def main(train: str, heldout: str) -> None:
    found = hc.diagnose(train, heldout, progress=tell)
    print(f"\r{found.summary}")
    found.model().save("diagnosed.toml", overwrite=True)


if __name__ == "__main__":
    main(*sys.argv[1:3])
