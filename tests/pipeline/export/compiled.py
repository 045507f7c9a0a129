"""A C header in a program that reads rows of numbers and prints the corrected vectors."""

import shutil
import subprocess
from pathlib import Path

import numpy as np

GCC = shutil.which("gcc")


def program_of(folder: Path, name: str, text: str, call: str, count: int = 3, stub: str = "") -> (
        Path):
    """Compile ``call``, which turns ``in[count]`` into ``out[3]``, without a warning."""
    assert GCC is not None
    (folder / name).write_text(text, encoding="utf-8")
    source, program = folder / "main.c", folder / "program"
    source.write_text(
        f'#include <stdio.h>\n{stub}\n#include "{name}"\n'
        f"int main(void) {{ float in[{count}], out[3]; int i;\n"
        f"for (;;) {{ for (i = 0; i < {count}; i++) if (scanf(\"%f\", in + i) != 1) return 0;\n"
        f"{call}\n"
        'printf("%.9g %.9g %.9g\\n", out[0], out[1], out[2]); } }\n',
        encoding="utf-8",
    )
    subprocess.run(
        [GCC, "-std=c99", "-Wall", "-Wextra", "-Werror", "-Wno-unused-const-variable",
         "-Wno-unused-function", "-o", str(program), str(source), "-lm"],
        check=True,
    )
    return program


def through(program: Path, rows: np.ndarray) -> np.ndarray:
    """The program's output for these rows."""
    lines = "".join(" ".join(f"{value:.9g}" for value in row) + "\n" for row in rows)
    done = subprocess.run([str(program)], input=lines, capture_output=True, text=True, check=True)
    return np.array([[float(word) for word in line.split()] for line in done.stdout.splitlines()])
