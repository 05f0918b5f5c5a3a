"""How far from the truth each method is on this physics.

    /usr/bin/python3 study.py

The truth is the force of the same physics at 1,000 steps a second, at the time that each displayed force is valid for.
"""
import numpy as np

from physics import run

METHODS = ["hold", "paper", "blend", "local"]
WARM = 6.0  # s, until a forecast has learnt the motion


def error(displayed, truth) -> float:
    """N, root of the mean square."""
    time, force = displayed
    later = (time >= WARM) & (time <= truth[0][-1])
    expected = np.stack([np.interp(time[later], truth[0], truth[1][:, axis]) for axis in range(3)], axis=1)
    return float(np.sqrt(((force[later] - expected) ** 2).sum(axis=1).mean()))


def main() -> None:
    _, truth = run(rate=1000.0)
    hold = None
    print("method  RMS error, N  share of hold's")
    for method in METHODS:
        displayed, _ = run(method)
        found = error(displayed, truth)
        hold = hold or found
        print(f"{method:6}  {found:12.4f}  {found / hold:15.2f}")


if __name__ == "__main__":
    main()
