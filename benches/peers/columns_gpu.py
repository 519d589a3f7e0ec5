#!/usr/bin/env python3
"""Columns of an orbit diagram of the valve, one trajectory a thread of a GPU, beside Chatter on this processor.

    python3 benches/peers/columns_gpu.py

The valve's tapes are printed as C++ (`tapes_as_cpp`), and compiled with cuda/columns.cu, which does what the library does with them:
for this processor, and with nvcc where there is one. All samples of the first columns must be those of Chatter to the bit. Then
returns a second are printed, by orders and by the number of columns: the work is that of columns.py.
"""

import json
import os
import shutil
import struct
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from environment import HERE, ROOT, processor

COMPARED = (40, 50, 200)
COLUMNS = (1_000, 4_096, 16_384, 65_536, 131_072, 524_288)
# As cuda/columns.cu counts them.
ORDERS = {"as the library chooses": "0", "the same in a loop": "1", "16": "16", "18": "18"}
CARGO = ["cargo", "run", "--release", "-q", "-p", "chatter-dynamics", "--example"]


def output(command, **options):
    return subprocess.run(command, check=True, capture_output=True, text=True, **options).stdout


def chatter(*counts):
    numbers = [str(count) for count in counts]
    return json.loads(output([*CARGO, "valve_columns", "--", *numbers], cwd=ROOT))


def compiled(folder, compiler, flags):
    """The program of cuda/columns.cu."""
    tapes = output([*CARGO, "tapes_as_cpp", "--", "models/pressure_relief_valve.toml"], cwd=ROOT)
    (folder / "valve.h").write_text(tapes)
    program = folder / compiler
    sources = [f"-I{folder}", f"-I{HERE / 'cuda'}", HERE / "cuda" / "columns.cu"]
    subprocess.run([compiler, "-std=c++17", "-O3", *flags, *sources, "-o", program], check=True)
    return program


def run(program, counts, order, samples=os.devnull):
    numbers = [str(count) for count in counts]
    return json.loads(output([program, *numbers, order], env=os.environ | {"CHATTER_SAMPLES": str(samples)}))


def compare(program, folder, reference):
    """Whether the samples are those of Chatter to the bit."""
    for order in ("0", "1"):
        run(program, COMPARED, order, folder / "samples")
        found = (folder / "samples").read_bytes()
        if found != struct.pack(f"{len(reference)}d", *reference):
            sys.exit(f"{program.name}: other samples than Chatter's")
    print(f"{program.name}: {len(reference)} samples are Chatter's to the bit", flush=True)


def main():
    print(processor())
    reference = chatter(*COMPARED)["samples"]
    with TemporaryDirectory() as name:
        folder = Path(name)
        compare(compiled(folder, "c++", ["-xc++", "-march=native", "-ffp-contract=off"]), folder, reference)
        for threads in (1, os.cpu_count()):
            rate = chatter(4_096 * threads, 100, 200, threads)["returns_per_second"]
            print(f"Chatter, {threads} threads: {rate:.0f} returns/s", flush=True)
        if not shutil.which("nvcc"):
            sys.exit("no nvcc: nothing more to measure")
        print(output(["nvidia-smi", "--query-gpu=name", "--format=csv,noheader"]).strip())
        program = compiled(folder, "nvcc", ["-arch=native", "-fmad=false"])
        compare(program, folder, reference)
        for named, order in ORDERS.items():
            rates = [run(program, (count, 100, 200), order)["returns_per_second"] for count in COLUMNS]
            print(f"{named:24}" + "".join(f"{rate / 1e6:8.2f}" for rate in rates) + " million returns/s", flush=True)


if __name__ == "__main__":
    main()
