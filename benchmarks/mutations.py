"""Broken files of every format that is read: a typed error or a right result, and nothing else.

Each file is a right one with a few mistakes, drawn from a fixed seed: bytes flipped, lost, doubled
or cut off, numbers replaced by others that no file should hold, lines swapped, brackets opened
thousandfold. A process a format reads them all; a file may take SECONDS and MEMORY.
"""

import argparse
import multiprocessing
import re
import resource
import signal
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np
from mutated_formats import FORMATS

COUNT = 2000  # files of all formats together, at least
SECONDS, MEMORY = 10, 3 << 30  # that one file may take
NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
NUMBERS = (
    b"nan", b"inf", b"-inf", b"1e400", b"-1", b"0", b"1e30", b"-1e30", b"4294967295", b"1e-320",
    b"99999999999999999999", b"", b"-0.0", b"0x10", b"1,5", b"true", b'"7"', b"[1]", b"null",
)  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=COUNT)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", help="one format")
    asked = parser.parse_args()
    names = [asked.only] if asked.only else list(FORMATS)
    each = -(-asked.count // len(names))
    print(f"{each} mutated files of each of {len(names)} formats, seed {asked.seed}\n")
    print("| format | right | refused | solved dark | slowest s | wrong |")
    print("| --- | ---: | ---: | ---: | ---: | --- |")
    wrong = 0
    for name in names:
        found, slowest = run(name, asked.seed, each)
        told = [key for key in found if key not in ("right", "refused", "dark")]
        wrong += sum(found[key] for key in told)
        words = "; ".join(f"{key} x {found[key]}" for key in told) or "-"
        print(f"| {name} | {found['right']} | {found['refused']} | {found['dark']} | "
              f"{slowest:.2f} | {words} |", flush=True)  # fmt: skip
    print(f"\n{each * len(names)} files, {wrong} wrong")


def run(name: str, seed: int, count: int) -> tuple[Counter, float]:
    """Return how many files of a format ended how, and the longest time one took."""
    found, slowest, start = Counter(), 0.0, 0
    context = multiprocessing.get_context("spawn")
    while start < count:
        mine, theirs = context.Pipe(duplex=False)
        process = context.Process(target=read_all, args=(name, seed, start, count, theirs))
        process.start()
        theirs.close()
        try:
            while start < count:
                kind, seconds = mine.recv()
                found[kind] += 1
                slowest = max(slowest, seconds)
                start += 1
        except EOFError:  # it died
            found[f"crash at {start}"] += 1
            start += 1
        process.join()
    return found, slowest


def read_all(name, seed, start, count, pipe):
    """Read the mutated files of a format from a number on, and tell of each how it ended."""
    original, suffix, read = FORMATS[name]
    signal.signal(signal.SIGALRM, _late)
    with tempfile.TemporaryDirectory() as folder:
        whole = original(Path(folder))
        path = Path(folder) / f"mutated{suffix}"
        path.write_bytes(whole)
        assert read(path) == "right", f"{name}: the file without mistakes is not read"
        resource.setrlimit(resource.RLIMIT_AS, (_in_use() + MEMORY,) * 2)
        for k in range(start, count):
            path.write_bytes(mutated(whole, np.random.default_rng([seed, k])))
            begun = time.perf_counter()
            pipe.send((_outcome(read, path, k), time.perf_counter() - begun))


def _outcome(read, path, k):
    """Return how reading a file ended: right, refused, dark or what went wrong."""
    import radiosity

    known = radiosity.Refused, radiosity.NotConverged
    signal.alarm(SECONDS)
    try:
        return read(path)
    except known:
        return "refused"
    except ValueError as error:  # a SceneError, or one that names the file
        named = isinstance(error, radiosity.SceneError) or str(error).startswith(str(path))
        return "refused" if named else f"{k}: {error}"
    except BaseException as error:
        return f"{k}: {type(error).__name__}: {str(error)[:60]}"
    finally:
        signal.alarm(0)


def _late(signum, frame):
    raise TimeoutError("took too long")


def _in_use() -> int:
    return int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()


def mutated(whole: bytes, rng: np.random.Generator) -> bytes:
    """Return a file with one to three mistakes."""
    data = bytearray(whole)
    for _ in range(rng.integers(1, 4)):
        MISTAKES[rng.integers(len(MISTAKES))](data, rng)
    return bytes(data)


def _place(data, rng):
    return int(rng.integers(len(data) + 1))


def _flip(data, rng):
    for _ in range(rng.integers(1, 9)):
        if data:
            data[rng.integers(len(data))] ^= 1 << int(rng.integers(8))


def _cut(data, rng):
    del data[_place(data, rng) :]


def _lose(data, rng):
    at = _place(data, rng)
    del data[at : at + int(rng.integers(1, 64))]


def _double(data, rng):
    at, to = _place(data, rng), _place(data, rng)
    data[to:to] = data[at : at + int(rng.integers(1, 200))]


def _number(data, rng):
    numbers = list(NUMBER.finditer(data))
    if numbers:
        one = numbers[rng.integers(len(numbers))]
        data[one.start() : one.end()] = NUMBERS[rng.integers(len(NUMBERS))]


def _word(data, rng):
    at = 4 * int(rng.integers(len(data) // 4 + 1))
    data[at : at + 4] = int(rng.choice([0, 1, 2**31 - 1, 2**32 - 1, 0x7FC00000])).to_bytes(
        4, "little"
    )


def _swap(data, rng):
    lines = bytes(data).split(b"\n")
    a, b = rng.integers(len(lines), size=2)
    lines[a], lines[b] = lines[b], lines[a]
    data[:] = b"\n".join(lines)


def _nest(data, rng):
    at = _place(data, rng)
    data[at:at] = [b"[", b"{", b"(", b"\0", b"\xff", b'"'][rng.integers(6)] * 3000


MISTAKES = _flip, _flip, _cut, _lose, _double, _number, _number, _word, _swap, _nest

if __name__ == "__main__":
    main()
