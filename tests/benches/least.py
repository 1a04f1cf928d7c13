#!/usr/bin/env python3
"""least.py [CRITERION_DIR]: the least time of each benchmark of the last `cargo bench`, as a table.

Criterion reports means, which others on the machine disturb; the least of its samples is what they
disturb least. CRITERION_DIR is target/criterion unless given.
"""
import json
import pathlib
import sys

folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "target/criterion")
rows = []
for file in sorted(folder.glob("**/new/sample.json")):
    sample = json.loads(file.read_text())
    bench = json.loads((file.parent / "benchmark.json").read_text())
    least = min(time / count for time, count in zip(sample["times"], sample["iters"]))
    elements = (bench["throughput"] or {}).get("Elements")
    rows.append((bench["full_id"], least / 1e6, least / elements if elements else None))
print("| benchmark | least ms | ns per pixel or polygon |\n|---|---|---|")
for name, ms, each in rows:
    print(f"| {name} | {ms:.3f} | {'' if each is None else f'{each:.3f}'} |")
