#!/usr/bin/env python3
"""How many sources are compiled again after a change of one file: a change of each kind, product + tests.

  python3 tests/layout/recompiles.py [CHECKOUT ...]   # default: this one; several stand side by side
  python3 tests/layout/recompiles.py --check          # exit 1 where a count of this checkout is above its bound

Follows the include lines of the sources, which gives what `ninja -n` says after a touch of the file; needs no build. The
generated sources that compile each header alone are left out.
"""
import os
import re
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
FOLDERS = ("core", "kernels", "scheduler", "cases/program", "tests")
INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.M)

# what is changed | its file (else where it was before) | most sources of the product that may follow
KINDS = [
    ("a contact law", ["core/rules/laws/hertz_tsuji.hpp", "kernels/kernel_table.cpp"], 1),
    ("the force of a law", ["kernels/models/linear.hpp"], 6),
    ("a list policy", ["scheduler/lists/policies/two_largest.hpp", "core/rules/skin.hpp"], 1),
    ("a node", ["scheduler/nodes/wall_contact.cpp"], 1),
    ("the header of a node", ["scheduler/nodes/wall_contact.hpp"], 5),
    ("a part", ["scheduler/parts/tracer.cpp"], 1),
    ("the socket of parts", ["scheduler/part.hpp"], 30),
    ("world.hpp", ["scheduler/step/world.hpp"], 15),
    ("a scene key", ["core/scene/sections/wall.cpp"], 1),
    ("what a line of a key can say", ["core/scene/key.hpp"], 20),
    ("a wall shape", ["core/walls/shapes/cone.cpp"], 1),
    ("an output quantity", ["core/frame/quantities.cpp"], 1),
    ("a member of the scene", ["core/scene/scene.hpp"], None),
]


def users_of(root):
    """File -> sources that reach it through their includes."""
    files = {}
    for folder in FOLDERS:
        for at, _, names in os.walk(os.path.join(root, folder)):
            for name in names:
                if name.endswith((".cpp", ".hpp")):
                    path = os.path.join(at, name)
                    with open(path, encoding="utf-8", errors="replace") as f:
                        files[os.path.relpath(path, root)] = INCLUDE.findall(f.read())
    users = {name: set() for name in files}
    for source in files:
        if not source.endswith(".cpp"):
            continue
        seen, todo = set(), [source]
        while todo:
            file = todo.pop()
            if file in seen or file not in files:
                continue
            seen.add(file)
            users[file].add(source)
            todo.extend(files[file])
    return users


def main():
    check = "--check" in sys.argv[1:]
    roots = [a for a in sys.argv[1:] if a != "--check"] or [ROOT]
    tables = [users_of(r) for r in roots]
    over = 0
    print(f"{'a change of':30}" + "".join(f"{r[-24:]:>26}" for r in roots))
    for kind, candidates, most in KINDS:
        row = f"{kind:30}"
        for users in tables:
            file = next((c for c in candidates if c in users), None)
            sources = users.get(file, set())
            tests = sum(s.startswith("tests/") for s in sources)
            product = len(sources) - tests
            row += f"{'no such file' if file is None else f'{product} + {tests}':>26}"
            if check and most is not None and (file != candidates[0] or product > most):
                over += 1
                row += f"   above {most}"
        print(row)
    sys.exit(1 if over else 0)


if __name__ == "__main__":
    main()
