"""The random numbers of the tests (SplitMix64: Steele, Lea, Flood 2014), whole arrays at once."""

import numpy as np

GAMMA = np.uint64(0x9E3779B97F4A7C15)


class Random:
    def __init__(self, seed):
        self.state = np.uint64(seed)

    def uniform(self, low, high, count):
        with np.errstate(over="ignore"):
            z = self.state + np.arange(1, count + 1, dtype=np.uint64) * GAMMA
            self.state = self.state + np.uint64(count) * GAMMA
            z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
            z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        z = z ^ (z >> np.uint64(31))
        return low + (high - low) * ((z >> np.uint64(11)).astype(float) / 2.0**53)

    def quaternion(self):
        """Unit (w, x, y, z), not uniform on the rotations."""
        x = self.uniform(-1.0, 1.0, 4)
        x[0] += 2.0
        return x / np.linalg.norm(x)
