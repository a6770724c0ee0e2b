"""Whether two rows that were measured in the same rounds differ."""

import numpy as np

PERMUTATIONS = 9999


def permutation_p(quiet, disturbed, seed=1):
    """Probability, if the disturbance did nothing, of figures at least so much larger with it.

    A permutation test: `quiet` and `disturbed` hold one array of per-second figures for each round; within a round,
    seconds change places at random. The statistic is the mean over rounds of the difference of the mean logarithms,
    so that one stall of the host does not decide. Seconds of a run are taken as exchangeable; where they hang together
    the test finds differences too readily rather than too seldom.
    """
    random = np.random.default_rng(seed)
    pairs = [(np.log(a), np.log(b)) for a, b in zip(quiet, disturbed, strict=True)]
    observed = np.mean([b.mean() - a.mean() for a, b in pairs])
    reached = 0
    for _ in range(PERMUTATIONS):
        differences = []
        for a, b in pairs:
            mixed = random.permutation(np.concatenate([a, b]))
            differences.append(mixed[len(a) :].mean() - mixed[: len(a)].mean())
        reached += np.mean(differences) >= observed
    return float(np.exp(observed)), (reached + 1) / (PERMUTATIONS + 1)
