"""The clones of vector functions give the same bytes.

wide_test.py SWEEP PLAIN_SWEEP: one runs the clones that the loader picks here, the other those for any x86-64.
"""
import subprocess
import sys


def said_by(program):
    lines = subprocess.run([program], check=True, capture_output=True, text=True).stdout.splitlines()
    return lines[0], lines[1:]


clones, found = said_by(sys.argv[1])
plain, found_plain = said_by(sys.argv[2])
print(f"{clones} and {plain}")
if clones != "x86-64-v3":
    print("this processor or this build has one kind of clone")
    sys.exit(77)
if plain != "default":
    sys.exit("the plain program does not run the default clones")
if len(found) < 10 or len(set(found)) < len(found):
    sys.exit("the sweep is not whole")
differing = [(a, b) for a, b in zip(found, found_plain, strict=True) if a != b]
for a, b in differing:
    print(f"{a}\n{b}")
sys.exit(bool(differing))
