"""Put the noise of the engine through dieharder (Debian: `apt-get install dieharder`).

    python tools/noise_battery.py              # the tests below, 15 minutes
    python tools/noise_battery.py 0 2 15       # chosen ones, by dieharder's numbers

The words are those that a run of 65 536 swimmers draws: all four of a block, swimmer after swimmer, step after step.
dieharder calls a test weak below p = 0.005 or above 0.995, which one in a hundred is by chance, and failed beyond 1e-6.
"""

import subprocess
import sys
from itertools import count

import numpy as np
import taichi as ti

from porous_swim.engine import backend
from porous_swim.physics.noise import Stream
from porous_swim.physics.philox import philox

# without those that dieharder itself calls suspect (5 to 7) or not to be used (14)
TESTS = [*range(5), *range(8, 14), 15, 16, 17, 100, 101, 102, *range(200, 210)]
TUPLES = {200: 8, 201: 5}  # tests that need to be told the size of their tuples
SWIMMERS = 1 << 16
SEED = 2
SAMPLES = 100  # p values to a test


@ti.kernel
def draw(step: ti.u32, seed: ti.u32, words: ti.types.ndarray(ti.u32, 2)):
    for i in range(words.shape[0]):
        w = philox(step, ti.u32(0), ti.cast(i, ti.u32), ti.u32(int(Stream.KICK)), seed, ti.u32(0))
        for k in ti.static(range(4)):
            words[i, k] = w[k]


def battery(test: int) -> str:
    """The lines of results of one test of dieharder."""
    columns = 8 + 16 + 64 + 128 + 256  # name, n-tuple, samples, p, assessment
    command = ["dieharder", "-g", "200", "-d", str(test), "-D", str(columns), "-p", str(SAMPLES)]
    if test in TUPLES:
        command += ["-n", str(TUPLES[test])]
    words = np.zeros((SWIMMERS, 4), np.uint32)
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            for step in count():
                draw(step, SEED, words)
                process.stdin.write(words.tobytes())
        except BrokenPipeError:  # it has seen enough
            pass
        return process.stdout.read().decode()


if __name__ == "__main__":
    backend.ensure("cpu")
    for number in [int(text) for text in sys.argv[1:]] or TESTS:
        print(battery(number), end="", flush=True)
