#!/usr/bin/env python3
"""instructions.py: instructions for each block of 16 pixels, and for each small triangle.

Counted by `valgrind --tool=callgrind`, for n things and for 2n: the difference is what n of them
take, without start-up. Prints the table as it stands in docs/benchmarks.md ("Instructions"), and
what has changed against that; exit code 1 if anything takes over 2 % more. valgrind 3.19 knows
no AVX-512.
"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile

ROWS = 64
LEVELS = ["scalar", "sse4.2", "avx2"]
# (as the table has it, case, precision, n, things that n stands for)
CASES = [
    ("block: texture, depth, `Fast`", "texture", "fast", 48, 48 * ROWS),
    ("block: texture, depth, `Exact`", "texture", "exact", 48, 48 * ROWS),
    ("block: 4 attributes, `Fast`", "attributes", "fast", 48, 48 * ROWS),
    ("block: 4 attributes, `Exact`", "attributes", "exact", 48, 48 * ROWS),
    ("block: hidden", "hidden", "fast", 48, 48 * ROWS),
    ("triangle of 10 pixels: colours, depth, `Fast`", "triangle", "fast", 2000, 2000),
    ("triangle of 10 pixels: colours, depth, `Exact`", "triangle", "exact", 2000, 2000),
    ("quad of 30 pixels: colours, depth, `Fast`", "quad", "fast", 2000, 2000),
    ("octagon of 45 pixels: colours, depth, `Fast`", "octagon", "fast", 2000, 2000),
    ("sliver of 50 pixels: colours, depth, `Fast`", "sliver", "fast", 2000, 2000),
]
MORE = 1.02


def build():
    """The path of the program that does the work."""
    command = ["cargo", "bench", "--no-run", "--bench", "instructions", "--message-format=json"]
    built = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
    messages = map(json.loads, built.splitlines())
    return [m["executable"] for m in messages if m.get("executable")][-1]


def count(program, case, level, precision, n):
    """Instructions of one run."""
    with tempfile.NamedTemporaryFile() as out:
        command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={out.name}"]
        command += [program, case, level, precision, str(n)]
        run = subprocess.run(command, capture_output=True, text=True)
        if run.returncode:
            sys.exit(f"{' '.join(command)}\n{run.stderr}")
        return int(re.search(r"^(?:summary|totals): (\d+)", out.read().decode(), re.M)[1])


def committed():
    """The table of docs/benchmarks.md: {(what, level): instructions}."""
    docs = pathlib.Path(__file__).parents[2] / "docs/benchmarks.md"
    section = re.search(r"^## Instructions\n(.*?)(?=^## |\Z)", docs.read_text(), re.M | re.S)
    table = {}
    for line in section[1].splitlines() if section else []:
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if len(cells) == 1 + len(LEVELS) and cells[1][:1].isdigit():
            table.update({(cells[0], level): int(n) for level, n in zip(LEVELS, cells[1:])})
    return table


def main():
    program, before, changed, worse = build(), committed(), [], False
    print("| instructions | " + " | ".join(LEVELS) + " |\n|---" + "|---" * len(LEVELS) + "|")
    for what, case, precision, n, things in CASES:
        row = []
        for level in LEVELS:
            once, twice = (count(program, case, level, precision, m) for m in (n, 2 * n))
            each = round((twice - once) / things)
            row.append(str(each))
            old = before.get((what, level))
            if old is not None and old != each:
                changed.append(f"{what}, {level}: {old} before, {each} now ({each / old - 1:+.1%})")
                worse |= each > MORE * old
        print(f"| {what} | " + " | ".join(row) + " |", flush=True)
    if not before:
        changed.append("docs/benchmarks.md has no table to compare with")
    print("\n".join(["", *(changed or ["nothing has changed"])]))
    sys.exit(1 if worse else 0)


main()
